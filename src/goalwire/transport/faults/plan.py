"""The faults of the moment: which of them applies to which packet."""

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
    """A session that applies changes of the faults to its graph."""

    def look_again(self) -> None:
        """Look at the partitions again: one may have changed."""

    def kill(self, name: str) -> None:
        """Remove a dead node's endpoints from the graph."""


class Plan:
    """The faults of the sessions that were opened with it; to be changed at any time, by any thread.

    The same seed gives the same fates to the same things sent on each path, whatever else is sent. Delays
    pass in the time of `clock`. Messages and requests meet their faults where they arrive and replies where
    they are sent: so it is the servers' and the subscriptions' processes that need the faults.
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
        """Part two nodes, or one node from all others."""
        return self.add(Partition(here, there, one_way=one_way, lease=lease))

    def heal(self, *faults: AnyFault) -> None:
        """End these faults, or all. The dead stay dead until a node of that name begins."""
        with self._lock:
            self._faults = tuple(each for each in self._faults if faults and each not in faults)
        self._look_again()

    def discard(self) -> None:
        """Lose the packets under way."""
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
        """How many deliveries wait for their time."""
        return self._delay_queue.under_way

    # -- what sessions ask ---------------------------------------------------------------------------------

    def opened(self, session: Watching) -> None:
        """Take note of a session that was opened."""
        with self._lock:
            self._sessions += (session,)
        self._look_again()

    def closed(self, session: Watching) -> None:
        """Take note of a closed session. With the last one the packets under way are lost."""
        with self._lock:
            self._sessions = tuple(each for each in self._sessions if each is not session)
            was_last = not self._sessions
        if was_last:
            self._delay_queue.clear()

    def revive(self, node: str) -> None:
        """A node of that name begins, which may have died before."""
        with self._lock:
            self._dead -= {node}

    def call(self, method: str) -> None:
        """A method of the transport is called. Raises TransportError if that shall fail."""
        for fault in self._faults:
            if isinstance(fault, FailedCall):
                fault.check(method)

    def passes(self, moment: Moment, packet: Packet) -> bool:
        """Whether a packet goes on at this moment; false from the moment on that an end of it is dead."""
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
        # A session may not be touched from where it delivers: the delay queue's thread removes the endpoints.
        self._delay_queue.do_later(0, lambda: self._kill_at(node))

    def send(self, packet: Packet, deliver: Callable[[Packet], None]) -> bool:
        """Deliver a packet as the faults change it, each part at its time; False if nothing is delivered."""
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
        """Whether `target` has noticed by now that nothing comes from `source`."""
        now = self._clock.now()
        return any(
            isinstance(fault, Partition) and fault.noticed_at <= now and fault.cuts(source, target)
            for fault in self._faults
        )

    def _look_again(self) -> None:
        """Let every session look at the graph, now and when the lease of a partition ends."""
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
