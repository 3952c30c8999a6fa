"""Decides what the other side of a link may do: which of its messages are let in, and what it is told.

The answer for a key is looked up once and then remembered with the receivers of that key. So a message costs
no more with a guard than without one.
"""

from __future__ import annotations

from enum import Enum
from typing import Protocol


class Act(Enum):
    """An act of the other side on a key that needs permission."""

    PUT = 'put'
    QUERY = 'query'
    REPLY = 'reply'
    DECLARE_SUBSCRIBER = 'subscriber'
    DECLARE_QUERYABLE = 'queryable'
    DECLARE_TOKEN = 'token'  # noqa: S105 - a liveliness token
    RECEIVE = 'receive'
    """Receive the messages that this session puts."""
    LEARN_SUBSCRIBER = 'learn of a subscriber'
    LEARN_QUERYABLE = 'learn of a queryable'
    LEARN_TOKEN = 'learn of a token'  # noqa: S105 - as above


class Guard(Protocol):
    """Knows the identity of a link's other side. Any thread may ask it, with the session's section held."""

    @property
    def who(self) -> str:
        """The name of the other side in its certificate."""

    @property
    def forwards(self) -> bool:
        """Whether the other side may pass on messages of others, as a router with rules of its own may."""

    def refusal(self, act: Act, key: str, session: str) -> str:
        """Return why the other side, whose session's id is given, may not do something; '' if it may."""

    def count(self, act: Act) -> None:
        """Count an act that was refused."""
