"""The handshake: each side sends its identity and abilities; the acceptor's answer is valid for both.

    connector: INIT -->                      acceptor: INIT taken
               <-- INIT, answer, cookie                answers with the smaller of both in each point
               OPEN, the cookie -->                    compares the cookie, looks for a second link
               <-- OPEN, answer                        up; frames may follow at once
    up

In other implementations the cookie lets an acceptor forget the connector until OPEN returns the cookie. This
acceptor remembers the connector, and the cookie only proves that the connector received the answer. A second
link to the same session is refused at OPEN, not earlier: until then the other side may still close its own
second link.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Protocol

from goalwire.records import record
from goalwire.zenoh.protocol.link_messages import (
    INIT,
    IS_ANSWER,
    MESSAGE_ID,
    OPEN,
    OUR_PATCH,
    Init,
    Open,
    Role,
)
from goalwire.zenoh.protocol.primitives import (
    GENERIC,
    INVALID,
    MAX_LINKS,
    TO_SELF,
    UNSUPPORTED,
    Reader,
    ZenohProtocolError,
)
from goalwire.zenoh.protocol.shared_memory import LinkMemory

SMALLEST_BATCH = 512
"""Bytes of the smallest batch that is accepted: in a smaller one, heads would leave no room for messages."""


@record
class Identity:
    """The identity of a session, as others see it. Times in ms."""

    zid: bytes
    role: Role
    lease_ms: int = 60_000
    batch_size: int = 65535


@record
class Terms:
    """The terms that both sides have agreed on, and the other side's identity."""

    zid: bytes
    """The other side's id (ZID)."""
    role: Role
    batch_size: int
    qos: bool
    patch: int
    lease_ms: int
    """How long the other side may be silent."""
    number_mask: int
    """The mask with all bits of a sequence number set."""
    first_sent: int
    """The first sequence number of this side, on every channel."""
    first_received: int


class MemoryAgreement(Protocol):
    """Negotiates shared memory for one link; each side proves that it can read the other's memory.

    No method raises. After any failure the link carries bytes only.
    """

    def offer(self) -> bytes | None:
        """Return what the connector offers in INIT."""

    def answer(self, theirs: bytes) -> bytes | None:
        """Return the acceptor's answer in INIT; None declines."""

    def prove(self, theirs: bytes) -> int | bytes | None:
        """Return the connector's proof in OPEN; None declines."""

    def accept(self, proof: int | bytes | None) -> int | bytes | None:
        """Return the acceptor's acceptance in OPEN; None declines."""

    def conclude(self, accepted: int | bytes | None) -> None:
        """Read the acceptor's acceptance. Only the connector calls this."""

    def make_memory(self, send: Callable[[bytes], object]) -> LinkMemory | None:
        """Return the memory of the link; None if the sides have not agreed. `send` sends a message."""

    def close(self) -> None:
        """Close everything that was opened, including the memory of the link, which has ended. Idempotent."""


class State(Enum):
    """The steps of a handshake."""

    WAIT_INIT = 'waits for INIT'
    WAIT_OPEN = 'waits for OPEN'
    UP = 'up'


class Handshake:
    """One side of one handshake. `answer` is the message to send next."""

    def __init__(
        self,
        identity: Identity,
        *,
        connects: bool,
        random: Callable[[int], bytes],
        expected: bytes | None = None,
        is_linked: Callable[[bytes], bool] = lambda _: False,
        memory: MemoryAgreement | None = None,
    ) -> None:
        """`random` makes bytes, `expected` is the id that must answer, `is_linked` is True for linked ids."""
        self.state = State.WAIT_INIT
        self.connects = connects
        self.terms: Terms | None = None
        self._identity = identity
        self._random = random
        self._expected = expected
        self._is_linked = is_linked
        self._memory = memory
        self._theirs: Init | None = None
        offer = memory.offer() if memory is not None and connects else None
        self._agreed = Init(identity.zid, identity.role, identity.batch_size, memory=offer)
        self._first_sent = int.from_bytes(random(4), 'little') >> 4

    def start(self) -> bytes:
        """Return the connector's first message; an acceptor sends nothing."""
        return self._agreed.encode() if self.connects else b''

    def make_memory(self, send: Callable[[bytes], object]) -> LinkMemory | None:
        """Return the shared memory of the link; None if the sides have not agreed. `send` sends a message."""
        return None if self._memory is None else self._memory.make_memory(send)

    def close(self) -> None:
        """Close everything that the handshake has opened: the link has ended."""
        if self._memory is not None:
            self._memory.close()

    def receive(self, reader: Reader) -> bytes:
        """Read one message and return the answer, b'' if there is none. Raises ZenohProtocolError."""
        header = reader.data[reader.at]
        # INIT comes first, then OPEN. The connector accepts only answers, the acceptor only first messages.
        wanted = INIT if self.state is State.WAIT_INIT else OPEN
        is_answer = bool(header & IS_ANSWER)
        if self.state is State.UP or header & MESSAGE_ID != wanted or is_answer != self.connects:
            raise ZenohProtocolError(f'message 0x{header:02x} while the handshake {self.state.value}')
        if wanted == INIT:
            return self._take_init(Init.decode(reader))
        return self._take_open(Open.decode(reader))

    def _take_init(self, theirs: Init) -> bytes:
        ours = self._agreed
        if theirs.batch_size < SMALLEST_BATCH:
            raise ZenohProtocolError(f'batches of {theirs.batch_size} bytes are too small', UNSUPPORTED)
        if self.connects:
            # The acceptor's answer decides. It may lower each value that was offered, but not raise it.
            if self._expected is not None and theirs.zid != self._expected:
                raise ZenohProtocolError('another session answers at this address', INVALID)
            if (
                theirs.batch_size > ours.batch_size
                or theirs.patch > ours.patch
                or theirs.number_size > ours.number_size
            ):
                raise ZenohProtocolError('the answer exceeds what was offered', INVALID)
        self._theirs = theirs
        # In each point the smaller of both values becomes valid. Only the acceptor adds a cookie.
        self._agreed = Init(
            ours.zid,
            ours.role,
            min(theirs.batch_size, ours.batch_size),
            theirs.qos and ours.qos,
            min(theirs.patch, OUR_PATCH),
            None if self.connects else self._random(16),
            min(theirs.number_size, ours.number_size),
            None if self.connects else self._answer_memory(theirs.memory),
        )
        self._first_sent &= self._agreed.number_mask
        self.state = State.WAIT_OPEN
        if self.connects:
            if theirs.zid == ours.zid:
                raise ZenohProtocolError('the peer has our own id: we connected to ourselves', TO_SELF)
            memory = self._memory
            proof = None if memory is None or theirs.memory is None else memory.prove(theirs.memory)
            return Open(self._identity.lease_ms, self._first_sent, theirs.cookie, proof).encode()
        return self._agreed.encode()

    def _answer_memory(self, theirs: bytes | None) -> bytes | None:
        return None if self._memory is None or theirs is None else self._memory.answer(theirs)

    def _take_open(self, theirs: Open) -> bytes:
        other, agreed = self._theirs, self._agreed
        assert other is not None
        if not self.connects:
            # Only the acceptor refuses a second link. If both sides did, they could refuse both links.
            if theirs.cookie != agreed.cookie:
                raise ZenohProtocolError('the cookie is not the one that was sent', INVALID)
            if other.zid == agreed.zid:
                raise ZenohProtocolError('the peer has our own id: we connected to ourselves', TO_SELF)
            if self._is_linked(other.zid):
                raise ZenohProtocolError('there is a link to this session already', MAX_LINKS)
        if theirs.first_number > agreed.number_mask:
            bits = agreed.number_mask.bit_length()
            raise ZenohProtocolError(f'first sequence number {theirs.first_number} has more than {bits} bits')
        if not theirs.lease_ms:
            raise ZenohProtocolError('a lease of 0', GENERIC)
        self.terms = Terms(
            other.zid,
            other.role,
            agreed.batch_size,
            agreed.qos,
            agreed.patch,
            theirs.lease_ms,
            agreed.number_mask,
            self._first_sent,
            theirs.first_number,
        )
        self.state = State.UP
        memory = self._memory
        if self.connects:
            if memory is not None:
                memory.conclude(theirs.memory)
            return b''
        accepted = None if memory is None else memory.accept(theirs.memory)
        return Open(self._identity.lease_ms, self._first_sent, memory=accepted).encode()
