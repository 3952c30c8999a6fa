"""A snapshot of an action's server: two of them show a client whether the server has changed."""

from __future__ import annotations

from hashlib import sha256

from goalwire.records import record

_NO_GOALS = bytes(4)
"""The length of an empty status array, in CDR."""


@record
class ServerSnapshot:
    """A client's view of an action's servers at one moment."""

    servers: frozenset[str]
    """The gids of the action's servers. A server has another gid after a restart."""
    statuses: str
    """A hash of the latest status array; '' before the first array, or if it names no goal."""


def hash_of_statuses(payload: bytes) -> str:
    """Return the hash of a status array in CDR; '' if there is no array, or if it names no goal."""
    if len(payload) < 8 or payload[4:8] == _NO_GOALS:
        return ''
    return sha256(payload).hexdigest()[:16]
