"""Decides what the other side of a link may do: which of its messages are accepted, and what it may learn.

The answer for a key is looked up once and then remembered with the receivers of that key. So a message costs
no more with a guard than without one.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Protocol, TypeAlias


class Act(Enum):
    """An act of the other side on a key that needs permission."""

    PUT = 'put'
    QUERY = 'query'
    REPLY = 'reply'
    DECLARE_SUBSCRIBER = 'subscriber'
    DECLARE_QUERYABLE = 'queryable'
    DECLARE_TOKEN = 'token'  # noqa: S105 - a liveliness token
    RECEIVE = 'receive'
    """Receive the messages that this session publishes."""
    LEARN_SUBSCRIBER = 'learn of a subscriber'
    LEARN_QUERYABLE = 'learn of a queryable'
    LEARN_TOKEN = 'learn of a token'  # noqa: S105 - as above


Witness: TypeAlias = Callable[[bytes | memoryview | None], object]
"""Is called with the payload of each message or query on a key, None for a deletion. It must not wait."""


class Guard(Protocol):
    """The permissions of a link's other side. Any thread that holds the session's section may ask it."""

    @property
    def who(self) -> str:
        """The name of the other side in its certificate."""

    @property
    def forwards(self) -> bool:
        """True if the other side may pass on messages of others, as a router with access control may."""

    def refusal(self, act: Act, key: str, session: str) -> str:
        """Return why the other side, with the id `session`, may not do `act` on `key`; '' if it may."""

    def count(self, act: Act, key: str) -> None:
        """Count an act that was refused."""

    def witness(self, act: Act, key: str) -> Witness | None:
        """Return the witness of each allowed `act` on `key`, if there is one. Called once for each key."""
