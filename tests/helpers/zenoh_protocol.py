"""Sessions of the pure protocol, linked by wires that are lists of bytes."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

from goalwire.zenoh.protocol.channels import Buffer
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.handshake import Handshake, Identity
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node
from goalwire.zenoh.protocol.outgoing import Outgoing
from goalwire.zenoh.protocol.primitives import ZenohProtocolError
from goalwire.zenoh.protocol.session_protocol import SessionProtocol

_seeds = itertools.count(1)


def random_bytes(size: int) -> bytes:
    """Return bytes that differ each time, and are the same in each run."""
    return next(_seeds).to_bytes(8, 'little')[:size].ljust(size, b'\x5a')


class Clock:
    """Time that stands still until told."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


class Wire:
    """One direction of a link: takes what is written as long as there is room."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.room: int | None = None
        self.wants_room = 0
        self.writes = 0
        self.held = 0
        self.waits = 0
        self.can_hold = False

    def write(self, data: Buffer) -> int:
        taken = len(data) if self.room is None else min(self.room, len(data))
        if self.room is not None:
            self.room -= taken
        self.writes += 1
        self.data += bytes(data[:taken])
        return taken

    def write_many(self, buffers: Sequence[Buffer]) -> int:
        return self.write(b''.join(bytes(each) for each in buffers))

    def request_flush(self) -> None:
        self.wants_room += 1

    def wait_for_room(self, is_answer: bool) -> None:
        self.waits += 1

    def hold(self, outgoing: Outgoing) -> None:
        self.held += 1

    def take(self) -> bytes:
        data, self.data = bytes(self.data), bytearray()
        return data


class Effects:
    """The owner of a session: notes what the session asks for, and closes links."""

    def __init__(self) -> None:
        self.to_meet: list[Node] = []
        self.changes = 0
        self.failures: list[Exception] = []
        self.refused: list[str] = []
        self.sooner = 0

    def meet(self, node: Node) -> None:
        self.to_meet.append(node)

    def welcome(self, link: Link) -> None:
        pass

    def close_link(self, link: Link, why: str, reason: int) -> None:
        link.close(reason)

    def note_change(self) -> None:
        self.changes += 1

    def expire_sooner(self) -> None:
        self.sooner += 1

    def refuse(self, kind: str, reason: object) -> None:
        self.refused.append(kind)

    def relink(self) -> None:
        pass

    def report(self, error: Exception) -> None:
        self.failures.append(error)


class Session(SessionProtocol):
    """A session whose effects are noted."""

    holds_back = False
    """Whether its links may hold messages back in a flood."""

    def __init__(self, zid: bytes, role: Role = Role.PEER, lease_ms: int = 60_000, **options: int) -> None:
        self.time = Clock()
        self.effects = Effects()
        self.failures = self.effects.failures
        self.refused = self.effects.refused
        self.to_meet = self.effects.to_meet
        super().__init__(
            Identity(zid, role, lease_ms, **options),
            self.effects,
            clock=self.time,
            wall_clock_ns=lambda: int(self.time.now * 1e9),
        )

    def new_link(self, *, connects: bool, expected: bytes | None = None) -> tuple[Link, Wire]:
        wire = Wire()
        handshake = Handshake(
            self.identity,
            connects=connects,
            random=random_bytes,
            expected=expected,
            is_linked=self.is_linked,
        )
        wire.can_hold = self.holds_back
        link = Link(self, handshake, wire, lease_ms=self.identity.lease_ms)
        return link, wire


class Cable:
    """A link between two sessions, the first of which connects."""

    def __init__(self, one: Session, other: Session) -> None:
        self.sessions = one, other
        self.links: tuple[Link, Link]
        first, second = one.new_link(connects=True), other.new_link(connects=False)
        self.links = first[0], second[0]
        self.wires = first[1], second[1]
        self.ends: list[Exception | None] = [None, None]

    def start(self) -> Cable:
        self.links[0].start()
        self.carry()
        return self

    def carry(self, cut: Callable[[bytes], Sequence[bytes]] = lambda data: [data]) -> None:
        """Carry bytes to and fro until there are none; `cut` makes the pieces in which they arrive."""
        while self.wires[0].data or self.wires[1].data:
            for at in (0, 1):
                for piece in cut(self.wires[at].take()):
                    self._hand_over(1 - at, piece)

    def _hand_over(self, to: int, piece: bytes) -> None:
        link = self.links[to]
        if not piece or not link.outgoing.is_open:
            return
        try:
            link.frames.receive(piece)
        except (ZenohProtocolError, ClosedByPeerError) as error:
            self.ends[to] = error
            link.close(error.reason if isinstance(error, ZenohProtocolError) else None)
            self.sessions[to].lose_link(link)

    def cut(self) -> None:
        """The connection breaks."""
        for link, session in zip(self.links, self.sessions, strict=True):
            link.close()
            session.lose_link(link)


def pair(
    one_role: Role = Role.PEER, other_role: Role = Role.PEER, **options: int
) -> tuple[Session, Session, Cable]:
    """Return two linked sessions."""
    one, other = Session(b'\xb1\xb2', one_role, **options), Session(b'\xa1\xa2', other_role)
    return one, other, Cable(one, other).start()
