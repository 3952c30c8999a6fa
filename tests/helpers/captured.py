"""Messages captured from a real ROS 2."""

from __future__ import annotations

from typing import NamedTuple


class Captured(NamedTuple):
    """One message: what it is, its DDS topic, its bytes, and what they mean."""

    what: str
    topic: str
    payload: bytes
    meaning: str
