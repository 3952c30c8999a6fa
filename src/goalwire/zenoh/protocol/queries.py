"""A query that this session has sent, its answers and its end.

A query goes to every link that has a queryable for it. Each of them ends its part with a final; a link that
breaks has ended its part too. The query is over when all parts are, or when its time is over. In the second
case it ends with an error "Timeout", as Zenoh's own do.

Consolidation decides what happens to several replies with the same key. None: all are handed over as they
come. Monotonic: none is handed over that is older than one before it. Latest: the newest of each key, at the
end.
"""

from __future__ import annotations

from collections.abc import Callable

from goalwire.zenoh.protocol.key_expressions import intersects
from goalwire.zenoh.protocol.network import Consolidation, ReplyError, Sample

TIMEOUT = ReplyError(b'Timeout')
ANY_KEY = '_anyke'
"""The parameter by which a query takes replies on any key."""

Answer = Sample | ReplyError


class PendingQuery:
    """A query on its way. `left` are the sessions that have not given their last answer."""

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
        """Hand an answer over, as the consolidation wants it; an answer on another key is thrown away."""
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
