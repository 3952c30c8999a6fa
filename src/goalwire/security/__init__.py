"""Identities and their rights: keystores and policies. Nothing here knows a transport."""

from __future__ import annotations

import os
from collections.abc import Mapping

KINDS = ('robot', 'person', 'program', 'router')
"""The kinds of identities. Data that a router forwards is subject to that router's rules."""


def is_asked_for(env: Mapping[str, str] = os.environ) -> bool:
    """Return True if the environment asks for security. If not, no other module of this package is needed."""
    return bool(env.get('GOALWIRE_SECURITY')) or env.get('ROS_SECURITY_ENABLE', '').lower() == 'true'
