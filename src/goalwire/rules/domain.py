"""The default domain: ROS_DOMAIN_ID, read from the environment."""

from __future__ import annotations

import os


def domain_from_environment() -> int:
    """Return the domain that ROS_DOMAIN_ID names, 0 if it is not set; raises ValueError for a bad value."""
    text = os.environ.get('ROS_DOMAIN_ID', '').strip()
    if not text:
        return 0
    if not text.isdecimal():
        raise ValueError(
            f"ROS_DOMAIN_ID is not an integral number: it is '{text}'; set it to a whole number from 0 on"
        )
    return int(text)
