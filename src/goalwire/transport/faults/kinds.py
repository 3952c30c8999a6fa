"""The kinds of faults, one class each, and the packet that they act on."""

from __future__ import annotations

import math
import os
import signal
from abc import ABC, abstractmethod
from collections import defaultdict, deque
from dataclasses import dataclass, field
from enum import Enum
from fnmatch import fnmatchcase
from random import Random
from typing import ClassVar, NamedTuple, TypeAlias

from goalwire.errors import TransportError
from goalwire.transport.contract import Payload

Path: TypeAlias = tuple['Kind', str, str, str]
"""Kind, name, source and target. The packets of one path keep their order."""


class Kind(Enum):
    """The kinds of packets."""

    MESSAGE = 'message'
    REQUEST = 'request'
    REPLY = 'reply'


class Packet(NamedTuple):
    """One message, request or reply. Nodes have qualified names; `source` is '' if the graph lacks it."""

    kind: Kind
    name: str
    """The name of the topic or service: '/chatter', '/move/_action/feedback'."""
    source: str
    target: str
    payload: Payload
    delay_ns: int = 0
    overtakes: bool = False
    """True if the packet need not wait for earlier packets of the same path."""

    @property
    def path(self) -> Path:
        """The packet's path: kind, name, source and target."""
        return self.kind, self.name, self.source, self.target


EVERYTHING: frozenset[Kind] = frozenset(Kind)


@dataclass(eq=False, kw_only=True)
class Fault(ABC):
    """One fault. `source`, `target` and `name` are shell patterns; 'arm' stands for the node '/arm'."""

    rate: float = 1.0
    """The probability from 0 to 1 that a packet is struck."""
    times: int | None = None
    """How many packets the fault strikes before it ends; None: no limit."""
    source: str = '*'
    target: str = '*'
    name: str = '*'
    kind: Kind | None = None
    struck: int = field(default=0, init=False)
    """How many packets the fault has struck."""

    strikes_on: ClassVar[frozenset[Kind]] = EVERYTHING

    def __post_init__(self) -> None:
        if not 0.0 <= self.rate <= 1.0:
            raise ValueError(f'the rate of a fault is a share from 0 to 1, got {self.rate}')
        self.source, self.target = qualify(self.source), qualify(self.target)

    def meets(self, packet: Packet) -> bool:
        """Return whether the fault applies to a packet, apart from its rate."""
        return (
            packet.kind in self.strikes_on
            and self.kind in {None, packet.kind}
            and fnmatchcase(packet.name, self.name)
            and fnmatchcase(packet.source, self.source)
            and fnmatchcase(packet.target, self.target)
        )

    def apply(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:
        """Return the packets that replace a packet at `now` (ns): none, itself, another one, or several."""
        if (self.times is not None and self.struck >= self.times) or not self.meets(packet):
            return (packet,)
        if self.rate < 1.0 and rng.random() >= self.rate:
            return (packet,)
        self.struck += 1
        return self.strike(packet, rng, now)

    @abstractmethod
    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:
        """Apply the fault to a packet."""


def qualify(node: str) -> str:
    """Return a node's name, or a pattern of names, with its namespace."""
    return node if node.startswith(('/', '*')) else f'/{node}'


def to_ns(seconds: float) -> int:
    """Return a duration in ns; raises ValueError for a negative one."""
    if not seconds >= 0:
        raise ValueError(f'a duration is not negative, got {seconds}')
    return int(seconds * 1e9)


@dataclass(eq=False)
class Loss(Fault):
    """Loses packets at the fault's rate."""

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return ()


@dataclass(eq=False)
class LostReply(Loss):
    """Loses only replies."""

    strikes_on = frozenset({Kind.REPLY})


@dataclass(eq=False)
class Delay(Fault):
    """Delays packets by `seconds`, and by up to `jitter` seconds more."""

    seconds: float = field(kw_only=False)
    jitter: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.seconds)
        to_ns(self.jitter)

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        extra = rng.uniform(0.0, self.jitter) if self.jitter else 0.0
        return (packet._replace(delay_ns=packet.delay_ns + to_ns(self.seconds + extra)),)


@dataclass(eq=False)
class Duplication(Fault):
    """Delivers packets twice, except replies, since a client takes only one."""

    strikes_on = frozenset({Kind.MESSAGE, Kind.REQUEST})

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return packet, packet


@dataclass(eq=False)
class Reordering(Fault):
    """Delays packets by `by` seconds, while later packets overtake them."""

    by: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.by)

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return (packet._replace(delay_ns=packet.delay_ns + to_ns(self.by), overtakes=True),)


@dataclass(eq=False)
class SlowReader(Fault):
    """A reader that needs `period` seconds for each packet, and handles `bytes_per_s` bytes a second.

    Each path has a reader of its own. Up to `room` messages of a topic wait; further ones are lost.
    """

    period: float = field(default=0.0, kw_only=False)
    bytes_per_s: float = math.inf
    room: int = 100
    lost: int = field(default=0, init=False)
    """How many messages found no room."""
    _busy: dict[Path, deque[int]] = field(default_factory=lambda: defaultdict(deque), init=False, repr=False)
    """For each packet under way, the time at which its path's reader has handled it."""

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.period)
        if not self.bytes_per_s > 0:
            raise ValueError(f'a reader takes some bytes a second, got {self.bytes_per_s}')

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        busy = self._busy[packet.path]
        while busy and busy[0] <= now:
            busy.popleft()
        if packet.kind is Kind.MESSAGE and len(busy) > self.room:
            self.lost += 1
            return ()
        arrival = now + packet.delay_ns
        due = max(arrival, busy[-1]) if busy else arrival
        busy.append(due + to_ns(self.period + len(packet.payload) / self.bytes_per_s))
        return (packet._replace(delay_ns=due - now),)


_HEADER = 4
"""Bytes of encapsulation before every message. A wire may read them itself, so no fault changes them."""


@dataclass(eq=False)
class FlippedBytes(Fault):
    """Changes `number` bytes of each packet."""

    number: int = 1

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        content = bytearray(packet.payload)
        for _ in range(self.number if len(content) > _HEADER else 0):
            content[rng.randrange(_HEADER, len(content))] ^= rng.randrange(1, 256)
        return (packet._replace(payload=bytes(content)),)


LEASE_S = 10.0
"""How long a silent peer stays in the graph: Zenoh's link lease and Cyclone's participant lease."""


@dataclass(eq=False)
class Partition(Fault):
    """Loses all packets from `here` to `there`, and back unless it is `one_way`.

    After `lease` seconds each side also removes the other from its graph, and ends the calls that wait for
    it.
    """

    here: str = field(kw_only=False)
    there: str = field(kw_only=False, default='*')
    one_way: bool = False
    lease: float = LEASE_S
    noticed_at: int = field(default=0, init=False)
    """The end of the lease, in ns of the clock."""

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.lease)
        self.here, self.there = qualify(self.here), qualify(self.there)

    def begin(self, now: int) -> None:
        """Begin the partition, and with it the lease."""
        self.noticed_at = now + to_ns(self.lease)

    def cuts(self, source: str, target: str) -> bool:
        """Return whether the partition stops packets from `source` to `target`."""
        return self._forth(source, target) or (not self.one_way and self._forth(target, source))

    def _forth(self, source: str, target: str) -> bool:
        return source != target and fnmatchcase(source, self.here) and fnmatchcase(target, self.there)

    def meets(self, packet: Packet) -> bool:
        return super().meets(packet) and self.cuts(packet.source, packet.target)

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return ()


_ENCAPSULATION = 4


class Moment(Enum):
    """The moments in a packet's life, at its sender and its receiver."""

    SENDING = 'before it is sent'
    SENT = 'once it is sent'
    ARRIVED = 'when it arrives, before anybody gets it'


class Point(Enum):
    """A point in the life of a call or goal: a kind of packet, the end of its name, and a moment."""

    REQUEST_RECEIVED = Kind.REQUEST, '', Moment.ARRIVED
    HANDLER_DONE = Kind.REPLY, '', Moment.SENDING
    MESSAGE_SENT = Kind.MESSAGE, '', Moment.SENT
    GOAL_RECEIVED = Kind.REQUEST, '/_action/send_goal', Moment.ARRIVED
    GOAL_ACCEPTED = Kind.REPLY, '/_action/send_goal', Moment.SENT
    FEEDBACK_SENT = Kind.MESSAGE, '/_action/feedback', Moment.SENT
    RESULT_READY = Kind.REPLY, '/_action/get_result', Moment.SENDING
    """The goal has ended, but its client does not know yet."""


@dataclass(eq=False)
class Kill:
    """Kills `node` once, when the `nth` packet of its service, topic or action `name` reaches `point`.

    With `process`, this process is ended by SIGKILL. Otherwise only the node is dead: from that moment
    nothing leaves or reaches it, and its endpoints vanish from the graph.
    """

    node: str
    point: Point
    name: str = '*'
    nth: int = field(default=1, kw_only=True)
    process: bool = field(default=False, kw_only=True)
    struck: int = field(default=0, init=False)
    struck_at: int = field(default=0, init=False)
    """The time of the kill, in ns of the faults' clock."""
    _met: int = field(default=0, init=False, repr=False)

    def __post_init__(self) -> None:
        self.node = qualify(self.node)

    def strikes(self, moment: Moment, packet: Packet) -> bool:
        """Count a packet that reaches `point`; return True if it is the `nth`."""
        kind, suffix, when = self.point.value
        server = packet.target if kind is Kind.REQUEST else packet.source
        if (
            self.struck
            or (kind, when) != (packet.kind, moment)
            or not fnmatchcase(server, self.node)
            or not fnmatchcase(packet.name, self.name + suffix)
            or (self.point is Point.GOAL_ACCEPTED and not packet.payload[_ENCAPSULATION])
        ):
            return False
        self._met += 1
        if self._met < self.nth:
            return False
        self.struck = 1
        return True

    @staticmethod
    def end_process() -> None:
        """End this process at once, as kill -9 does."""
        os.kill(os.getpid(), getattr(signal, 'SIGKILL', signal.SIGTERM))


@dataclass(eq=False)
class FailedCall:
    """The `nth` call of `method` ('publish', 'session.close', …; any, by default) raises TransportError."""

    method: str = '*'
    nth: int = field(default=1, kw_only=True)
    struck: int = field(default=0, init=False)
    struck_method: str = field(default='', init=False)
    """The method of the call that failed."""
    _met: int = field(default=0, init=False, repr=False)

    def check(self, method: str) -> None:
        """Count a call; raise TransportError if it is the `nth`."""
        if self.struck or not fnmatchcase(method, self.method):
            return
        self._met += 1
        if self._met == self.nth:
            self.struck, self.struck_method = 1, method
            raise TransportError(f"'{method}' failed: a fault injected as call {self.nth} of '{self.method}'")
