"""What is declared at a place, a session's nodes or a node's endpoints: it leaves with the place."""

from __future__ import annotations

from threading import Lock
from typing import Protocol, TypeVar

from goalwire.transport.endpoint_state import EndpointState


class Child(Protocol):
    """Something declared."""

    @property
    def gid(self) -> bytes:
        """What it is known by."""

    def close(self) -> None:
        """Undeclare it."""


M = TypeVar('M', bound=Child)


class Children:
    """The members of one place, by gid; safe from any thread."""

    def __init__(self, state: EndpointState) -> None:
        self._state = state
        self._lock = Lock()
        self._children: dict[bytes, Child] = {}

    def keep(self, child: M) -> M:
        """Take note of a new one and return it. Where the place was given up meanwhile, raises ClosedError.

        The member is closed then. So giving up finds all that were noted, and none comes later.
        """
        with self._lock:
            if not self._state.closed:
                self._children[child.gid] = child
                return child
        child.close()
        self._state.check()
        return child

    def forget(self, gid: bytes) -> None:
        """One has left; an unknown one is no error."""
        with self._lock:
            self._children.pop(gid, None)

    def close(self) -> None:
        """Close all that are there: for the place that is being given up."""
        with self._lock:
            children = list(self._children.values())
        for child in children:
            child.close()
