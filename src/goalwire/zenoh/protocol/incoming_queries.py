"""Received queries for a queryable of this session; their answers go to this session, or over a link."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from goalwire.zenoh.protocol.bodies import (
    Payload,
    QueryMessage,
    Sample,
    new_sample,
    put_body,
)
from goalwire.zenoh.protocol.network import (
    BLOCK,
    REPLY_HEADER,
    ReplyError,
    error_body,
    response_final,
    response_head,
    whole_answer,
)
from goalwire.zenoh.protocol.outgoing import Outgoing
from goalwire.zenoh.protocol.queries import Answer, PendingQuery


class Query(ABC):
    """A received query, for one queryable: answer it any number of times, then `end` it. Any thread."""

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
        """Send an answer; `stamp` and `source` are encoded already. Does nothing after the query's end."""
        if self._open:
            self._send(new_sample((key, payload, attachment, stamp, source)))

    def reply_error(self, payload: bytes) -> None:
        """Send an error in place of an answer."""
        if self._open:
            self._send(ReplyError(payload))

    def end(self) -> None:
        """End the answers of this queryable. Idempotent."""
        if self._closes():
            self._finish()

    def answer(self, key: str, payload: Payload, attachment: bytes | None = None) -> None:
        """Send the only answer, and end the query."""
        if self._closes():
            try:
                self._send(new_sample((key, payload, attachment, None, None)))
            finally:
                self._finish()

    def _closes(self) -> bool:
        """Mark the query as ended. Return False if it had ended before."""
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
        """Tell the querier that this queryable's answers are complete."""


class LocalQuery(Query):
    """A query of this session to a queryable of its own."""

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
        if self._pending.left:  # the query is neither cancelled nor timed out
            self._pending.reply(answer)

    def _finish(self) -> None:
        self._when_finished()


class RemoteQuery(Query):
    """A query that came over a link. `others` has an entry for each of its queryables that still answers."""

    __slots__ = ('_others', '_outgoing', '_qos', '_replier', '_request')

    def __init__(
        self,
        outgoing: Outgoing,
        request: int,
        key: str,
        qos: int,
        message: QueryMessage,
        replier: bytes,
        others: list[None],
    ) -> None:
        super().__init__(key, message.parameters, message.payload, message.attachment)
        self._outgoing = outgoing
        self._request = request
        self._qos = qos
        self._replier = replier
        self._others = others

    def answer(self, key: str, payload: Payload, attachment: bytes | None = None) -> None:
        """Send the only answer and the end of the query, in one frame if they fit."""
        if len(self._others) > 1 or not self._closes():
            super().answer(key, payload, attachment)
            return
        message = whole_answer(self._request, key, self._qos, self._replier, payload, attachment)
        if len(message) <= self._outgoing.room:
            self._transmit(message)
        else:  # A message in pieces must be sent alone.
            final = response_final(self._request, self._qos)
            self._transmit(message[: -len(final)])
            self._transmit(final)

    def _send(self, answer: Answer) -> None:
        self._transmit(self._response(answer))

    def _finish(self) -> None:
        """Send RESPONSE_FINAL if all other queryables have ended: each request gets one over a link."""
        with self._outgoing.lock:
            self._others.pop()
            if self._others:
                return
        self._transmit(response_final(self._request, self._qos))

    def _transmit(self, message: bytes) -> None:
        self._outgoing.send(2 * (self._qos & 7) + 1, message, not self._qos & BLOCK, is_answer=True)

    def _response(self, answer: Answer) -> bytes:
        """Return the RESPONSE for an answer, or with the error for the query's own key."""
        if type(answer) is Sample:
            head = response_head(self._request, answer.key, self._qos, self._replier)
            payload = answer.payload
            assert payload is not None
            return head + REPLY_HEADER + put_body(payload, answer.attachment, answer.stamp, answer.source)
        head = response_head(self._request, self.key, self._qos, self._replier)
        assert isinstance(answer, ReplyError)
        return head + error_body(answer.payload)
