"""Publishers: send messages, and keep the history that transient_local subscriptions ask for.

The keys and queries of that history are in subscription.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from time import time_ns
from typing import TYPE_CHECKING, NamedTuple

from goalwire.errors import ClosedError, TransportError
from goalwire.fault_reports import LOGGER
from goalwire.transport import contract
from goalwire.transport.contract import Endpoint, PublisherPort
from goalwire.transport.endpoint import EndpointState, OpenPort
from goalwire.transport.zenoh.attachment import GID_SIZE, encode
from goalwire.transport.zenoh.context import LARGE, Turn, Waiting, ZenohContext
from goalwire.transport.zenoh.ros_keys import actual_depth
from goalwire.transport.zenoh.wire import Left, LoanPublisher, Publisher, Wire, refuse_use
from goalwire.zenoh.protocol.shared_memory import Loan

if TYPE_CHECKING:
    from goalwire.payload_parts import Parts

LARGEST = 1 << 30
"""The largest message in bytes that a Zenoh session receives, by default and in rmw_zenoh's settings."""

SLOWER = 'the network or a subscription is slower than the publisher'

LEAVING_S = 5.0
"""How long the closing of a publisher waits for its large messages."""


def may_block(endpoint: Endpoint) -> bool:
    """Return whether publishing may wait for room on the wire."""
    waits = endpoint.waits_for_room
    if waits is None:
        waits = endpoint.qos.keeps_all or endpoint.qos.is_transient_local
    return endpoint.qos.is_reliable and waits


def declare(wire: Wire, key: str, endpoint: Endpoint) -> Publisher:
    """Declare a publisher that puts messages on `key` as the endpoint's QoS asks."""
    qos = endpoint.qos
    waits = may_block(endpoint)
    # On the wire, rmw_zenoh's advanced publisher without history behaves as a plain publisher.
    if not qos.is_transient_local:
        return wire.declare_publisher(key, reliable=qos.is_reliable, waits=waits)
    return wire.declare_history_publisher(key, reliable=qos.is_reliable, waits=waits, depth=actual_depth(qos))


class Large(NamedTuple):
    """How a publisher sends messages that are too large for a link's queue."""

    blocks: bool
    """True if `publish` waits for room, as it does for small messages."""
    waits: bool
    """True if a thread of each full link waits for room with the message. Otherwise the message may be
    dropped, as any message of a best-effort publisher."""
    depth: int
    """How many messages may wait for one link."""


def large(endpoint: Endpoint) -> Large:
    """Return how an endpoint's large messages are sent."""
    qos = endpoint.qos
    waits = qos.is_reliable and endpoint.waits_for_room is not False
    return Large(may_block(endpoint), waits, actual_depth(qos))


class ZenohPublisher(OpenPort, PublisherPort):
    """A declared publisher.

    Zenoh stamps a message inside `put`. A subscription of rmw_zenoh drops a message whose stamp is not newer
    than the last one of the same session and key. So all publishers of a session on one key share a `turn`:
    messages are numbered, stamped and sent in one order.
    """

    def __init__(
        self,
        context: ZenohContext,
        state: EndpointState,
        gid: bytes,
        publisher: Publisher,
        turn: Turn,
        large: Large,
    ) -> None:
        super().__init__(state, gid)
        self._context = context
        self._put: Callable[..., None] = publisher.put
        self._put_where_free: Callable[..., Sequence[Left]] = publisher.put_where_free
        self._lender: LoanPublisher | None = publisher if isinstance(publisher, LoanPublisher) else None
        self.can_lend = self._lender is not None
        self._refusals: tuple[type[Exception], ...] = (*context.errors, MemoryError, TransportError)
        self._next_sequence = count(1).__next__
        self._turn = turn
        self._section = turn.section
        self._large = large
        self._dropped = 0

    @property
    def dropped(self) -> int:
        """How many large messages were dropped here; each counts once for each peer that did not get it.

        Zenoh does not report other drops.
        """
        return self._dropped

    def publish(self, payload: bytes | Parts) -> None:
        """Put one message.

        If several threads publish, all subscriptions get the messages in the same order.
        """
        state = self.state
        # Checked before the section is entered: a forked child could wait for it for ever.
        if state.closed or state.guard.is_silent:
            state.check_sending()
        section = self._section
        entered = False
        try:
            section.acquire()  # hot path: `run` of CriticalSection, written out
            if section.is_busy:
                section.late.append(partial(self._publish_late, bytes(payload)))
                return
            if section.late:
                section.run_late()
            entered = section.is_busy = True
            if state.guard.is_silent:  # the context may have ended while this thread waited
                state.check_sending()
            if len(payload) >= LARGE or self._turn.is_busy:
                self._publish_large(payload)
            else:
                self._put(payload, attachment=encode(self._next_sequence(), time_ns(), GID_SIZE, self.gid))
        except ClosedError:
            raise  # the context has ended meanwhile, and zenoh was not called
        except self._context.errors as error:
            state.check()  # another thread may have closed the publisher in the meantime
            reason = self._context.wire.explain(error)
            raise TransportError(f'{state.title}: zenoh refused a message: {reason}') from None
        finally:
            try:
                if entered:
                    section.is_busy = False
                    if section.late:
                        section.run_late()
            finally:
                try:  # noqa: SIM105
                    section.release()
                except RuntimeError:  # not held: a signal handler raised an exception in `acquire`
                    pass

    def borrow(self, size: int) -> contract.Loan | None:
        """Return a chunk of shared memory to write a message into; None if there is none."""
        if self._lender is None or self.state.closed or self.state.guard.is_silent:
            return None
        return self._lender.borrow(size)

    def publish_loan(self, loan: contract.Loan) -> None:
        """Publish the message in a loan, without a copy if all subscribers can read shared memory."""
        if self._section.is_entered():  # a signal handler has interrupted a publish: send after it
            self.publish(bytes(loan.view))
        else:
            self._section.run(partial(self._put_loan, loan))

    def _put_loan(self, loan: contract.Loan) -> None:
        self.state.check_sending()
        lender = self._lender
        if lender is not None and isinstance(loan, Loan) and not self._turn.is_busy:
            is_put = lender.put_loan(loan, self._attach)
        else:
            is_put = False
        if not is_put:
            self._publish_large(bytes(loan.view))

    def _attach(self) -> bytes:
        return encode(self._next_sequence(), time_ns(), GID_SIZE, self.gid)

    def _publish_late(self, payload: bytes) -> None:
        """Publish a message that a signal handler published during a publish. Runs in the section."""
        try:
            if self.state.closed or self.state.guard.is_silent:
                return
            if len(payload) >= LARGE or self._turn.is_busy:
                self._publish_large(payload)
            else:
                self._put(payload, attachment=encode(self._next_sequence(), time_ns(), GID_SIZE, self.gid))
        except self._refusals as error:
            reason = self._context.wire.explain(error) or type(error).__name__
            self._note_drop([len(payload)], f'zenoh refused it: {reason}')

    def _publish_large(self, payload: bytes | Parts) -> None:
        """Publish a large message, or one that must follow waiting ones. The caller is in the section."""
        if len(payload) > LARGEST:
            raise TransportError(
                f'{self.state.title}: a message of {len(payload)} bytes cannot be sent, for peers take '
                f'{LARGEST} bytes at most; publish it in parts'
            )
        large, turn = self._large, self._turn
        if large.blocks:
            turn.wait()
            self.state.check_sending()  # the context may have ended meanwhile
        attachment = encode(self._next_sequence(), time_ns(), GID_SIZE, self.gid)
        if large.blocks or not (turn.is_busy or large.waits):
            self._put(payload, attachment=attachment)
            return
        size = len(payload)
        for link, send in self._put_where_free(payload, attachment, turn.lanes, waits=large.waits):
            dropped = turn.post(link, Waiting(self, size, partial(self._send, send, size)), large.depth)
            if dropped is not None:
                self._note_drop(
                    [dropped.size], f'{SLOWER}, and {large.depth} newer ones wait already (the history depth)'
                )

    def _send(self, send: Callable[[], None], size: int) -> None:
        try:
            send()
        except self._refusals as error:
            reason = self._context.wire.explain(error) or type(error).__name__
            self._note_drop([size], f'zenoh refused it: {reason}')

    def _note_drop(self, sizes: Sequence[int], why: str) -> None:
        """Count messages that were dropped; the first is logged."""
        first = not self._dropped
        self._dropped += len(sizes)
        if first:
            from goalwire.logging import get_logger

            get_logger(LOGGER).warning(
                f'{self.state.title}: a message of {sizes[0]} bytes was dropped: {why}; '
                f'further ones are counted only'
            )

    def leave(self) -> None:
        """Stop publishing.

        If another thread is publishing, the publisher is undeclared after that.
        """
        cancelled = self._turn.finish(self, LEAVING_S)
        self._put = self._put_where_free = refuse_use
        self._lender = None
        if cancelled:
            self._note_drop(
                cancelled, f'{SLOWER}; it had not gone {LEAVING_S} s after the publisher was closed'
            )
