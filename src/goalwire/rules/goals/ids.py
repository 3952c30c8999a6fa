"""Goal ids: sixteen bytes, which the client makes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from uuid import UUID

GoalId = bytes

ID_LENGTH = 16
NO_ID: GoalId = bytes(ID_LENGTH)
"""The id in a cancel request that names no single goal."""


def new_goal_id(random: bytes | None = None) -> GoalId:
    """Return a fresh id in the form of a version 4 UUID, from 16 `random` bytes or the system's."""
    source = os.urandom(ID_LENGTH) if random is None else random
    version = source[6] & 0x0F | 0x40
    variant = source[8] & 0x3F | 0x80
    return source[:6] + bytes((version, source[7], variant)) + source[9:ID_LENGTH]


def read_goal_id(given: bytes | UUID) -> GoalId:
    """Return the id that a program gives as 16 bytes or as a uuid.UUID.

    Raises TypeError for another type; ValueError for another length, and for sixteen zero bytes, since a
    request to cancel that id would cancel every goal of the server.
    """
    if not isinstance(given, bytes):
        from uuid import UUID

        if not isinstance(given, UUID):
            raise TypeError(f'a goal id is {ID_LENGTH} bytes or a uuid.UUID, not {type(given).__name__}')
        given = given.bytes
    if len(given) != ID_LENGTH:
        raise ValueError(f'a goal id has {ID_LENGTH} bytes, got {len(given)}')
    if given == NO_ID:
        raise ValueError('sixteen zeros are not a goal id: in a cancel request they stand for all goals')
    return given
