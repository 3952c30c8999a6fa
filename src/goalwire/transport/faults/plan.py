"""The plan of faults: the current ones, and their effect on each packet."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from threading import Lock
from typing import Protocol, TypeAlias, TypeVar

from goalwire.transport.faults.delay_queue import Clock, DelayQueue, RealTime
from goalwire.transport.faults.kinds import LEASE_S, FailedCall, Fault, Kill, Moment, Packet, Partition, Path

AnyFault: TypeAlias = Fault | Kill | FailedCall
FaultT = TypeVar('FaultT', bound=AnyFault)


class Watching(Protocol):
    """A session that updates its graph when the faults change."""

    def look_again(self) -> None:
        """Update the graph, since a partition may have changed."""

    def kill(self, name: str) -> None:
        """Remove a dead node's endpoints from the graph."""


class Plan:
    """The faults of the sessions that were opened with it. Any thread may change them at any time.

    With the same seed the same packets on a path meet the same faults, whatever is sent on other paths.
    Delays pass in the time of `clock`. Faults are applied to messages and requests where they arrive, and to
    replies where they are sent: so the processes of servers and subscriptions need the faults.
    """

    def __init__(self, *faults: AnyFault, seed: int = 0, clock: Clock | None = None) -> None:
        self.seed = seed
        self._clock: Clock = clock or RealTime()
        self._delay_queue = DelayQueue(self._clock)
        self._lock = Lock()
        self._rng: dict[Path, Random] = {}
        self._faults: tuple[AnyFault, ...] = ()
        self._sessions: tuple[Watching, ...] = ()
        self._dead: frozenset[str] = frozenset()
        for fault in faults:
            self.add(fault)

    # -- what a test does ----------------------------------------------------------------------------------

    def add(self, fault: FaultT) -> FaultT:
        """Add a fault, which applies from now on; returns it."""
        if isinstance(fault, Partition):
            fault.begin(self._clock.now())
        with self._lock:
            self._faults += (fault,)
        self._look_again()
        return fault

    def partition(
        self, here: str, there: str = '*', *, one_way: bool = False, lease: float = LEASE_S
    ) -> Partition:
        """Add a partition between two nodes, or between one node and all others."""
        return self.add(Partition(here, there, one_way=one_way, lease=lease))

    def heal(self, *faults: AnyFault) -> None:
        """End the given faults, or all. A killed node stays dead until a new node takes its name."""
        with self._lock:
            self._faults = tuple(each for each in self._faults if faults and each not in faults)
        self._look_again()

    def discard(self) -> None:
        """Drop the packets under way."""
        self._delay_queue.clear()

    @property
    def active(self) -> tuple[AnyFault, ...]:
        """The faults at this moment."""
        return self._faults

    @property
    def dead(self) -> frozenset[str]:
        """The nodes that have been killed, by their qualified names."""
        return self._dead

    @property
    def under_way(self) -> int:
        """How many packets wait for their time."""
        return self._delay_queue.under_way

    # -- what sessions ask ---------------------------------------------------------------------------------

    def add_session(self, session: Watching) -> None:
        """Add a session that was opened."""
        with self._lock:
            self._sessions += (session,)
        self._look_again()

    def remove_session(self, session: Watching) -> None:
        """Remove a closed session. After the last one the packets under way are dropped."""
        with self._lock:
            self._sessions = tuple(each for each in self._sessions if each is not session)
            was_last = not self._sessions
        if was_last:
            self._delay_queue.clear()

    def revive(self, node: str) -> None:
        """Note that a node of this name is alive again."""
        with self._lock:
            self._dead -= {node}

    def call(self, method: str) -> None:
        """Count a call of a transport's method. Raises TransportError if a fault makes it fail."""
        for fault in self._faults:
            if isinstance(fault, FailedCall):
                fault.check(method)

    def passes(self, moment: Moment, packet: Packet) -> bool:
        """Strike at this moment of a packet's way; return False if its source or its target is dead then."""
        for fault in self._faults:
            if isinstance(fault, Kill) and fault.strikes(moment, packet):
                self._kill(packet.target if moment is Moment.ARRIVED else packet.source, fault)
        return not self._dead.intersection((packet.source, packet.target))

    def _kill(self, node: str, fault: Kill) -> None:
        if fault.process:
            fault.end_process()
        fault.struck_at = self._clock.now()
        with self._lock:
            self._dead |= {node}
        # This may run inside a session's delivery, so another thread, the delay queue's, removes the
        # endpoints.
        self._delay_queue.do_later(0, lambda: self._kill_at(node))

    def send(self, packet: Packet, deliver: Callable[[Packet], None]) -> bool:
        """Apply the faults to a packet and deliver the resulting packets when due; False if none results."""
        with self._lock:
            results = self._fate(packet)
        for result in results:
            self._delay_queue.carry(
                packet.path,
                result.delay_ns,
                lambda result=result: deliver(result),  # type: ignore[misc]
                overtakes=result.overtakes,
            )
        return bool(results)

    def _fate(self, packet: Packet) -> tuple[Packet, ...]:
        results: tuple[Packet, ...] = (packet,)
        faults = [fault for fault in self._faults if isinstance(fault, Fault)]
        if faults:
            now = self._clock.now()
            rng = self._rng_of(packet.path)
            for fault in faults:
                results = tuple(after for each in results for after in fault.apply(each, rng, now))
        return results

    def _rng_of(self, path: Path) -> Random:
        rng = self._rng.get(path)
        if rng is None:
            kind, *names = path
            rng = self._rng[path] = Random(f'{self.seed} {kind.value} {names}')  # noqa: S311
        return rng

    def parted(self, source: str, target: str) -> bool:
        """Return whether a partition has cut `source` off from `target` for longer than its lease."""
        now = self._clock.now()
        return any(
            isinstance(fault, Partition) and fault.noticed_at <= now and fault.cuts(source, target)
            for fault in self._faults
        )

    def _look_again(self) -> None:
        """Let every session update its graph, now and when the lease of a partition ends."""
        for session in self._sessions:
            session.look_again()
        now = self._clock.now()
        for fault in self._faults if self._sessions else ():
            if isinstance(fault, Partition) and fault.noticed_at > now:
                self._delay_queue.do_later(fault.noticed_at - now, self._notice)

    def _notice(self) -> None:
        for session in self._sessions:
            session.look_again()

    def _kill_at(self, node: str) -> None:
        for session in self._sessions:
            session.kill(node)
