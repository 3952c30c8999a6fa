"""Queries: those that this session has sent, and those that came and wait for an answer.

A query goes to every link that has a queryable for it. Each of them ends its part with a final; a link that
breaks has ended its part too. The query is over when all parts are, or when its time is over. In the second
case it ends with an error "Timeout", as Zenoh's own do.

Consolidation decides what happens to several replies with the same key. None: all are handed over as they
come. Monotonic: none is handed over that is older than one before it. Latest: the newest of each key, at the
end.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING

from goalwire.zenoh.protocol.key_expressions import intersects
from goalwire.zenoh.protocol.network import (
    BLOCK,
    REPLY_HEADER,
    Consolidation,
    Payload,
    QueryMessage,
    ReplyError,
    Sample,
    error_body,
    new_sample,
    put_body,
    response_final,
    response_head,
    whole_answer,
)

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.link import Link

TIMEOUT = ReplyError(b'Timeout')
ANY_KEY = '_anyke'
"""The parameter by which a query takes replies on any key."""

Answer = Sample | ReplyError


class PendingQuery:
    """A query on its way. `left` are those that have not had their last word."""

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
        """Hand an answer over, as consolidation has it; one on another key than was asked is thrown away."""
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
        """All have had their last word, or there is no time left. Called once."""
        if self._consolidation == Consolidation.LATEST:
            for answer in self._kept.values():
                self._on_reply(answer)
        self._on_end()


def _is_newer(one: Sample, other: Sample) -> bool:
    mine, others = one.timestamp, other.timestamp
    return others is None or (mine is not None and mine.time >= others.time)


class Query(ABC):
    """A query that came, for one queryable: answer it any number of times, then `end` it. Any thread."""

    __slots__ = ('_open', 'attachment', 'key', 'parameters', 'payload')

    def __init__(self, key: str, parameters: str, payload: Payload | None, attachment: bytes | None) -> None:
        self.key = key
        self.parameters = parameters
        self.payload = payload
        self.attachment = attachment
        self._open = [None]

    def reply(
        self,
        key: str,
        payload: Payload,
        attachment: bytes | None = None,
        stamp: bytes | None = None,
        source: bytes | None = None,
    ) -> None:
        """Answer; `stamp` and `source` as the wire has them. Nothing happens once the query has ended."""
        if self._open:
            self._send(new_sample((key, payload, attachment, stamp, source)))

    def reply_error(self, payload: bytes) -> None:
        """Say why there is no answer."""
        if self._open:
            self._send(ReplyError(payload))

    def end(self) -> None:
        """There is nothing more to say. Idempotent."""
        if self._closes():
            self._finish()

    def answer(self, key: str, payload: Payload, attachment: bytes | None = None) -> None:
        """Answer and end in one."""
        if self._closes():
            try:
                self._send(new_sample((key, payload, attachment, None, None)))
            finally:
                self._finish()

    def _closes(self) -> bool:
        """Whether it is this call that ends the query."""
        try:
            self._open.pop()
        except IndexError:
            return False
        return True

    @abstractmethod
    def _send(self, answer: Answer) -> None:
        """Send an answer to the querier."""

    @abstractmethod
    def _finish(self) -> None:
        """Tell the querier that this queryable has nothing more to say."""


class LocalQuery(Query):
    """A query of the session's own."""

    __slots__ = ('_pending', '_when_finished')

    def __init__(
        self,
        message: QueryMessage,
        pending: PendingQuery,
        when_finished: Callable[[], None],
    ) -> None:
        super().__init__(pending.key, message.parameters, message.payload, message.attachment)
        self._pending = pending
        self._when_finished = when_finished

    def _send(self, answer: Answer) -> None:
        if self._pending.left:  # it has not ended: cancelled, or out of time
            self._pending.reply(answer)

    def _finish(self) -> None:
        self._when_finished()


class RemoteQuery(Query):
    """A query that came over a link; `others` counts the queryables of it that have not ended yet."""

    __slots__ = ('_link', '_others', '_qos', '_replier', '_request')

    def __init__(
        self,
        link: Link,
        request: int,
        key: str,
        qos: int,
        message: QueryMessage,
        replier: bytes,
        others: list[None],
    ) -> None:
        super().__init__(key, message.parameters, message.payload, message.attachment)
        self._link = link
        self._request = request
        self._qos = qos
        self._replier = replier
        self._others = others

    def answer(self, key: str, payload: Payload, attachment: bytes | None = None) -> None:
        """Answer and end in one frame, where it fits."""
        if len(self._others) > 1 or not self._closes():
            super().answer(key, payload, attachment)
            return
        message = whole_answer(self._request, key, self._qos, self._replier, payload, attachment)
        if len(message) <= self._link.room:
            self._transmit(message)
        else:  # pieces are of one message alone
            final = response_final(self._request, self._qos)
            self._transmit(message[: -len(final)])
            self._transmit(final)

    def _send(self, answer: Answer) -> None:
        self._transmit(self._response(answer))

    def _finish(self) -> None:
        with self._link.lock:
            self._others.pop()
            if self._others:
                return
        self._transmit(response_final(self._request, self._qos))

    def _transmit(self, message: bytes) -> None:
        self._link.send(2 * (self._qos & 7) + 1, message, not self._qos & BLOCK, is_answer=True)

    def _response(self, answer: Answer) -> bytes:
        if type(answer) is Sample:
            head = response_head(self._request, answer.key, self._qos, self._replier)
            payload = answer.payload
            assert payload is not None
            return head + REPLY_HEADER + put_body(payload, answer.attachment, answer.stamp, answer.source)
        head = response_head(self._request, self.key, self._qos, self._replier)
        assert isinstance(answer, ReplyError)
        return head + error_body(answer.payload)
