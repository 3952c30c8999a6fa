"""Goal ids: sixteen bytes, which the client makes."""

from __future__ import annotations

import os

GoalId = bytes

ID_LENGTH = 16
NO_ID: GoalId = bytes(ID_LENGTH)
"""In a cancel request: no goal in particular."""


def new_goal_id(random: bytes | None = None) -> GoalId:
    """Return a fresh id in the form of a version 4 UUID, from 16 `random` bytes or the system's."""
    source = os.urandom(ID_LENGTH) if random is None else random
    version = source[6] & 0x0F | 0x40
    variant = source[8] & 0x3F | 0x80
    return source[:6] + bytes((version, source[7], variant)) + source[9:ID_LENGTH]
