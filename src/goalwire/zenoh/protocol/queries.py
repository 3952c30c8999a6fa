"""A query that this session has sent, its answers and its end.

A query goes to every link that has a queryable for it. Each link ends its answers with a final; a broken link
ends them, too. The query is over when all links have ended their answers, or at its timeout. In the second
case it ends with an error "Timeout", as in Zenoh's own library.

Consolidation decides which of several replies with the same key are handed over. None: all replies, as they
come. Monotonic: the replies that are not older than an earlier one. Latest: the newest reply of each key, at
the end.
"""

from __future__ import annotations

from collections.abc import Callable

from goalwire.zenoh.protocol.bodies import Consolidation, Sample
from goalwire.zenoh.protocol.key_expressions import intersects
from goalwire.zenoh.protocol.network import ReplyError

TIMEOUT = ReplyError(b'Timeout')
ANY_KEY = '_anyke'
"""The parameter of queries that accept replies on any key."""

Answer = Sample | ReplyError


class PendingQuery:
    """A query that was sent. `left` are the links and own queryables whose last answer is missing."""

    __slots__ = (
        '_consolidation',
        '_kept',
        '_on_end',
        '_on_reply',
        'deadline',
        'encoded_key',
        'key',
        'left',
        'takes_any_key',
    )

    def __init__(
        self,
        key: str,
        encoded_key: bytes,
        left: list[object],
        deadline: float,
        on_reply: Callable[[Answer], None],
        on_end: Callable[[], None],
        *,
        takes_any_key: bool,
        consolidation: int = Consolidation.NONE,
    ) -> None:
        self.key = key
        self.encoded_key = encoded_key
        self.left = left
        self.deadline = deadline
        self.takes_any_key = takes_any_key
        self._on_reply = on_reply
        self._on_end = on_end
        self._consolidation = consolidation
        self._kept: dict[str, Sample] = {}

    def reply(self, answer: Answer) -> None:
        """Hand an answer over as the consolidation requires. An answer on another key is thrown away."""
        if type(answer) is not Sample:
            self._on_reply(answer)
            return
        key = answer.key
        if key != self.key and not self.takes_any_key and not intersects(key, self.key):
            return
        if self._consolidation == Consolidation.NONE:
            self._on_reply(answer)
            return
        before = self._kept.get(key)
        if before is None or _is_newer(answer, before):
            self._kept[key] = answer
            if self._consolidation == Consolidation.MONOTONIC:
                self._on_reply(answer)

    def end(self) -> None:
        """End the query: the answers are complete, or it has timed out. Called once."""
        if self._consolidation == Consolidation.LATEST:
            for answer in self._kept.values():
                self._on_reply(answer)
        self._on_end()


def _is_newer(one: Sample, other: Sample) -> bool:
    mine, others = one.timestamp, other.timestamp
    return others is None or (mine is not None and mine.time >= others.time)
