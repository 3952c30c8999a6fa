"""Publications, each for one key. They look up the receivers of the key, and remember them."""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from goalwire.zenoh.protocol.bodies import (
    LARGE,
    Payload,
    Sample,
    del_body,
    new_sample,
    put_body,
    put_head,
    shared_put_head,
)
from goalwire.zenoh.protocol.channels import channel_of
from goalwire.zenoh.protocol.expressions import Namer, name_in_full
from goalwire.zenoh.protocol.guard import Act
from goalwire.zenoh.protocol.key_expressions import canonical
from goalwire.zenoh.protocol.network import (
    BLOCK,
    DEFAULT_QOS,
    push_head,
    wire_key,
)
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT, Outgoing
from goalwire.zenoh.protocol.primitives import (
    SourceInfo,
    encode_source,
)
from goalwire.zenoh.protocol.session_protocol import SessionProtocol
from goalwire.zenoh.protocol.shared_memory import Loan, Pointer, encode_pointer

if TYPE_CHECKING:
    from goalwire.payload_parts import Parts

FLOOD = 32
"""More messages in a row than this are a flood (see `Stamps.burst`): the following messages may wait a
moment, to go out together. A callback that publishes twenty messages does not count as a flood."""
SMALL = 2048
"""Only messages of fewer bytes may wait. For a larger message the system call costs little in comparison."""
_NEVER = float('inf')
WHOLE = (bytes, memoryview)
"""The types of payloads in one piece; the others are Parts."""
Lent: TypeAlias = 'list[tuple[Outgoing, bytes, Pointer]]'
"""Links that get a message as a pointer, each with the head of the message and the pointer."""
Links: TypeAlias = 'tuple[tuple[Outgoing, bytes], ...]'
"""Links that get a message, each with the head of the message, which names the key as that link knows it."""


def _take_back(lent: Lent) -> None:
    for link, _, pointer in lent:
        if link.memory is not None:
            link.memory.take_back(pointer)


class Publication:
    """Publishes messages on one key."""

    def __init__(
        self,
        session: SessionProtocol,
        key: str,
        *,
        priority: int = DEFAULT_QOS,
        reliable: bool = True,
        droppable: bool = True,
    ) -> None:
        self._session = session
        self._routes = session.routes
        self._key = canonical(key)
        self._channel = channel_of(priority, reliable=reliable)
        self._qos = priority if droppable else priority | BLOCK
        self._droppable = droppable
        self._version = -1
        self._links: Links = ()
        self._own: tuple[Callable[[Sample], None], ...] = ()
        self._shared_from: float = _NEVER
        """Payloads of this many bytes or more go through shared memory, on links that have some."""
        self._is_open = True
        self.number = session.next_number()
        session.use_key(self._key)

    def put(
        self,
        payload: Payload | Parts,
        attachment: bytes | None = None,
        stamp: bytes | None = None,
        source: SourceInfo | None = None,
    ) -> None:
        """Publish a message; `stamp` defaults to the session's next. Own subscribers are called at once."""
        session = self._session
        if self._version != self._routes.version:
            self._aim()
        if stamp is None:
            stamp = session.stamp()
        encoded_source = None if source is None else encode_source(source)
        links, size = self._links, len(payload)
        if size >= self._shared_from:
            links = self._share(payload, shared_put_head(attachment, stamp, encoded_source), links)
        if links:
            if size >= LARGE or not isinstance(payload, WHOLE):
                self._put_large(bytes(payload), put_head(size, attachment, stamp, encoded_source), links)
            else:
                body = put_body(payload, attachment, stamp, encoded_source)
                may_wait = size < SMALL and session.stamps.burst > FLOOD
                for link, head in links:
                    link.send(self._channel, head + body, self._droppable, may_wait)
        if self._own:
            whole = payload if isinstance(payload, WHOLE) else bytes(payload)
            sample = new_sample((self._key, whole, attachment, stamp, encoded_source))
            self._deliver(sample)

    def _share(self, payload: Payload | Parts, begin: bytes, links: Links) -> Links:
        """Send a payload through shared memory to the links that can take it; return the others.

        The payload is copied into a chunk once for all these links, and not copied if there are none.
        """
        pool = self._session.memory
        loan = None if pool is None else pool.borrow(len(payload))
        if loan is None:
            return links
        lent: Lent = []
        left: list[tuple[Outgoing, bytes]] = []
        try:
            for link, head in links:
                pointer = None if link.memory is None else link.memory.lend(loan)
                if pointer is None:
                    left.append((link, head))
                else:
                    lent.append((link, head, pointer))
            try:
                if lent and not loan.write(payload):
                    return links  # the session is closing, and has taken all loans back
            except BaseException:  # another thread has changed the message, or a signal handler has raised
                _take_back(lent)
                raise
            self._send_pointers(lent, begin)
        finally:
            loan.end()
        return tuple(left)

    def put_loan(self, loan: Loan, attach: Callable[[], bytes]) -> bool:
        """Publish a message that was written into a loan; `attach` makes its attachment.

        Return False, without publishing, if it cannot go through shared memory to all receivers.
        """
        if self._version != self._routes.version:
            self._aim()
        lent: Lent = []
        for link, head in self._links:
            pointer = None if link.memory is None else link.memory.lend(loan)
            if pointer is None:
                _take_back(lent)
                return False
            lent.append((link, head, pointer))
        attachment, stamp = attach(), self._session.stamp()
        self._send_pointers(lent, shared_put_head(attachment, stamp, None))
        if self._own:
            self._deliver(new_sample((self._key, bytes(loan.view), attachment, stamp, None)))
        return True

    def _send_pointers(self, lent: Lent, begin: bytes) -> None:
        for link, head, pointer in lent:
            message = b''.join((head, begin, encode_pointer(pointer)))
            if not link.send(self._channel, message, self._droppable) and link.memory is not None:
                link.memory.take_back(pointer)

    def _put_large(self, payload: bytes, begin: bytes, links: Links) -> None:
        """Send a PUT without copying its large payload: fresh memory of 1 MB costs over a millisecond."""
        for link, head in links:
            link.send_large(self._channel, (head + begin, payload), droppable=self._droppable)

    def put_where_free(
        self,
        payload: Payload | Parts,
        attachment: bytes | None,
        full: Container[object],
        *,
        waits: bool,
        stamp: bytes | None = None,
        source: SourceInfo | None = None,
    ) -> list[tuple[Outgoing, Callable[[], None]]]:
        """Publish one message on the links that have room. Return the other links, each with a function that
        sends the message there.

        The links in `full` count as links without room. With `waits`, the function waits for room before and
        after sending; otherwise it may drop the message.
        """
        session = self._session
        if self._version != self._routes.version:
            self._aim()
        if stamp is None:
            stamp = session.stamp()
        encoded_source = None if source is None else encode_source(source)
        size = len(payload)
        begin = put_head(size, attachment, stamp, encoded_source)
        # The key is named in full: its number may be undeclared before the message is sent.
        late = push_head(wire_key(self._key), self._qos | BLOCK if waits else self._qos) + begin
        left: list[tuple[Outgoing, Callable[[], None]]] = []
        links = self._links
        if size >= self._shared_from:
            free = tuple(each for each in links if each[0] not in full)
            shared = shared_put_head(attachment, stamp, encoded_source)
            not_shared = self._share(payload, shared, free)
            links = tuple(each for each in links if each[0] in full or each in not_shared)
        data = bytes(payload) if links else b''
        for link, head in links:
            if link not in full and (not waits or link.queue.size + size <= QUEUE_LIMIT):
                link.send_large(self._channel, (head + begin, data), droppable=self._droppable)
            else:
                left.append((link, partial(self._send_late, link, (late, data), droppable=not waits)))
        if self._own:
            whole = payload if isinstance(payload, WHOLE) else bytes(payload)
            sample = new_sample((self._key, whole, attachment, stamp, encoded_source))
            self._deliver(sample)
        return left

    def _send_late(self, link: Outgoing, message: tuple[bytes, bytes], *, droppable: bool) -> None:
        link.send_large(self._channel, message, droppable=droppable)
        if not droppable:
            link.wait_for_room()  # otherwise the small messages after a large one would be dropped

    def delete(self) -> None:
        """Tell the subscribers that the key has no value any more (DEL)."""
        session = self._session
        if self._version != self._routes.version:
            self._aim()
        stamp = session.stamp()
        body = del_body(None, stamp)
        for link, head in self._links:
            link.send(self._channel, head + body, self._droppable)
        self._deliver(Sample(self._key, None, None, stamp))

    def _deliver(self, sample: Sample) -> None:
        for callback in self._own:
            try:
                callback(sample)
            except Exception as error:
                self._session.report(error)

    def _aim(self) -> None:
        """Look up the receivers of the key."""
        if not self._session.section.run(
            partial(self._find, self._session.expressions.declare, is_final=True)
        ):
            self._find(name_in_full, is_final=False)

    def _find(self, name: Namer, *, is_final: bool) -> None:
        session, key = self._session, self._key
        version = session.routes.version
        self._own = tuple(
            each.callback for _, each in session.routes.subscribers.meeting(key) if each.takes_own
        )
        # A link that has not sent all its declarations may have a subscriber, so it gets the message, too. In
        # a look-up that interrupts a change (`is_final` is False), the tables are not trusted and all links
        # get it.
        self._links = tuple(
            (link.outgoing, push_head(name(link, key), self._qos))
            for link in session.links
            if (not is_final or not link.peer.knows_all or link.peer.subscribers.has_meeting(key))
            and not link.refusal(Act.RECEIVE, key)
        )
        pool = session.memory
        has_memory = pool is not None and any(link.memory is not None for link, _ in self._links)
        self._shared_from = pool.least if pool is not None and has_memory else _NEVER
        if is_final:  # set last: other threads only check the version before they send
            self._version = version

    def close(self) -> None:
        """Give up the number of the key. Idempotent."""
        self._session.section.run(self._close)

    def _close(self) -> None:
        if self._is_open:
            self._is_open = False
            self._session.expressions.discard(self._key, self._session.links)
