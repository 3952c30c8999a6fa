"""Identities and their rights: keystores and policies. Nothing here knows a transport."""

from __future__ import annotations

import os
from collections.abc import Mapping


def is_asked_for(env: Mapping[str, str] = os.environ) -> bool:
    """Whether the environment asks for security. If not, nothing else of this package need be imported."""
    return bool(env.get('GOALWIRE_SECURITY')) or env.get('ROS_SECURITY_ENABLE', '').lower() == 'true'
