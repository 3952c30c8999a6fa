"""What is declared at a place, a session's nodes or a node's endpoints: it leaves with the place."""

from __future__ import annotations

from threading import Lock
from typing import Protocol, TypeVar

from goalwire.transport.place import Place


class Member(Protocol):
    """Something declared."""

    @property
    def gid(self) -> bytes:
        """What it is known by."""

    def close(self) -> None:
        """Undeclare it."""


M = TypeVar('M', bound=Member)


class Members:
    """The members of one place, by gid; safe from any thread."""

    def __init__(self, place: Place) -> None:
        self._place = place
        self._lock = Lock()
        self._members: dict[bytes, Member] = {}

    def keep(self, member: M) -> M:
        """Take note of a new one and return it. Where the place was given up meanwhile, raises ClosedError.

        The member is closed then. So giving up finds all that were noted, and none comes later.
        """
        with self._lock:
            if not self._place.closed:
                self._members[member.gid] = member
                return member
        member.close()
        self._place.check()
        return member

    def forget(self, gid: bytes) -> None:
        """One has left; an unknown one is no error."""
        with self._lock:
            self._members.pop(gid, None)

    def close(self) -> None:
        """Close all that are there: for the place that is being given up."""
        with self._lock:
            members = list(self._members.values())
        for member in members:
            member.close()
