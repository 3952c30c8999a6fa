"""A participant with its sockets, which are read by the threads that wait on them."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Sized
from functools import partial
from time import monotonic, time_ns

from goalwire.concurrency.forks import ForkGuard, open_privately
from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.poller import IN, Poller, Timer
from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.fault_reports import RejectCounters
from goalwire.host_addresses import LOOPBACK, LOOPBACK_V6, Interface, choose, find_interfaces
from goalwire.rtps.io.addresses import Reach, choose_announced_addresses, choose_announced_hosts, first_port
from goalwire.rtps.io.interface_changes import InterfaceChanges
from goalwire.rtps.io.settings import Settings
from goalwire.rtps.io.sockets import Sockets
from goalwire.rtps.protocol import discovery
from goalwire.rtps.protocol.discovery import ParticipantListener
from goalwire.rtps.protocol.identity import RANDOM_SIZE, make_prefix
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.primitives import NS, Address
from goalwire.rtps.protocol.writer import Writer

__all__ = ['RtpsSession', 'Settings']

PACKETS_A_TURN = 64
"""How many packets of one socket are read before the next socket has its turn."""
CLOSING_S = 1.0
"""How long closing waits for readers to acknowledge what was sent."""


class _Listener(ParticipantListener):
    """Counts refused data, and passes all other events on."""

    def __init__(self, inner: ParticipantListener, rejects: RejectCounters) -> None:
        self._rejects = rejects
        self.on_participant = inner.on_participant  # type: ignore[method-assign]
        self.on_participant_lost = inner.on_participant_lost  # type: ignore[method-assign]
        self.on_endpoint = inner.on_endpoint  # type: ignore[method-assign]
        self.on_endpoint_lost = inner.on_endpoint_lost  # type: ignore[method-assign]

    def on_refused(self, kind: str, reason: str) -> None:
        self._rejects.add(kind, reason)


class RtpsSession:
    """One open participant and its sockets.

    Idle threads may wait in `wire_poller`; `participant` has all other methods.
    """

    def __init__(
        self,
        settings: Settings,
        listener: ParticipantListener | None = None,
        *,
        awaited: Sized = (),
        rejects: RejectCounters | None = None,
        starts: bool = True,
    ) -> None:
        """Open the participant and its sockets. Raises TransportError.

        `awaited` is passed to `WireSet.awaited`; `rejects` counts refused data. If `starts` is false, the
        caller must call `start`.
        """
        first_port(settings.domain, settings.ports)
        self.guard = ForkGuard()
        self.rejects = RejectCounters() if rejects is None else rejects
        """Counts of ignored data from others, by kind."""
        self._settings = settings
        self._is_local = settings.reach is Reach.LOCALHOST and not settings.peers
        self._interfaces, self._own_hosts = self._look_at_interfaces()
        self._sockets = Sockets(settings, self._interfaces)
        prefix = make_prefix(self._sockets.port, os.urandom(RANDOM_SIZE))
        name = f'goalwire-rtps {prefix.hex()[8:16]}'
        self._poller = open_privately(lambda: Poller(name, portable=settings.portable, awaited=awaited))
        self.wire_poller = LeaderFollowers(self._poller, name)
        self._timer: Timer | None = None
        self._changes: InterfaceChanges | None = None
        self._sleepers: set[SleepingThread] = set()
        self._is_closed = False
        self.participant = Participant(
            self._participant_settings(prefix),
            _Listener(listener or ParticipantListener(), self.rejects),
            clock=monotonic,
            wall_clock_ns=time_ns,
            send=self._sockets.send,
            send_parts=self._sockets.send_parts,
            on_sooner=self._set_timer,
            on_acknowledged=self._wake_sleepers,
        )
        try:
            for sock in self._sockets.receivers:
                self._poller.register(sock.fileno(), IN, partial(self._read, sock))
            if settings.reach is not Reach.OFF:
                self._changes = InterfaceChanges(self._poller, self._on_interfaces)
            if starts:
                self.start()
        except BaseException:
            self.close()
            raise

    def start(self) -> None:
        """Announce the participant, and begin to read packets."""
        self.participant.start()
        self.wire_poller.start()

    # ---- interfaces

    def _look_at_interfaces(self) -> tuple[tuple[Interface, ...], frozenset[str]]:
        """Look up and return the interfaces to use, and all addresses of this host."""
        settings = self._settings
        all_of_them = find_interfaces(ipv6=settings.ipv6)
        loopback = LOOPBACK_V6 if settings.ipv6 else LOOPBACK
        own = frozenset({loopback, *(each.address for each in all_of_them)})
        return choose(all_of_them, settings.interfaces, settings.excluded), own

    def _participant_settings(self, prefix: bytes) -> discovery.Settings:
        """Return the settings of the participant, which knows the network only by them."""
        settings = self._settings
        return discovery.Settings(
            prefix=prefix,
            domain=settings.domain,
            metatraffic=self._sockets.metatraffic,
            default=self._sockets.default,
            peers=self._choose_announced(),
            own_hosts=self._own_hosts,
            lease=int(settings.lease_s * NS),
            user_data=settings.user_data,
            name=settings.name,
            tag=settings.tag,
            announce_s=settings.announce_s,
            packet_size=settings.packet_size,
            ipv6=settings.ipv6,
            receive_buffer=self._sockets.receive_buffer,
        )

    def _choose_announced(self) -> tuple[Address, ...]:
        """Return the addresses to which the participant announces itself."""
        settings = self._settings
        if settings.reach is Reach.OFF:
            return ()
        hosts: tuple[str, ...] = ()
        if settings.announces_here:
            own = tuple(each.address for each in self._interfaces)
            hosts = choose_announced_hosts(own, chosen=bool(settings.interfaces), ipv6=settings.ipv6)
        return choose_announced_addresses(
            settings.domain,
            hosts,
            settings.peers,
            settings.groups if settings.announces_to_group else (),
            ports=settings.ports,
            participants=settings.participants,
        )

    def _on_interfaces(self) -> None:
        """If the addresses of this host have changed, use the new addresses and announce them."""
        found = self._look_at_interfaces()
        if found == (self._interfaces, self._own_hosts) or self._is_closed:
            return
        self._interfaces, self._own_hosts = found
        self._sockets.use(self._interfaces)
        self.participant.move(
            self._sockets.metatraffic, self._sockets.default, self._choose_announced(), self._own_hosts
        )

    # ---- what comes

    def _read(self, sock: socket.socket, _events: int) -> None:
        packets = self._sockets.read(sock, PACKETS_A_TURN)  # first: reading frees the socket's buffer
        if len(packets) > 1 and sock is not self._sockets.discovery:
            # Discovery first: a listener may reply to a sample, and may know the reader for its reply only
            # then.
            self._read(self._sockets.discovery, IN)
        if self._is_local:
            own_hosts = self._own_hosts
            for each in tuple(packets):
                if each[1][0] not in own_hosts:
                    packets.remove(each)
                    self.rejects.add('packet from another host', each[1][0])
        if len(packets) == 1:
            self.participant.receive(*packets[0])
        elif packets:
            self.participant.receive_all(packets)

    def _set_timer(self) -> None:
        """Let the poller wake when the participant's next timer is due."""
        timer, due = self._timer, self.participant.next_due
        if timer is not None:
            timer.cancel()
        self._timer = self._poller.call_later(max(0.0, due - monotonic()), self.participant.advance)

    # ---- writing

    def write(
        self, writer: Writer, payload: bytes, *, qos: bytes = b'', to: bytes | None = None
    ) -> int | None:
        """Write a sample and return its number; None if the writer stays full for `max_blocking`.

        A thread that waits for room also reads the sockets, if no other thread does. A call from a callback
        of the thread that reads the sockets does not wait: the acknowledgements that make room come through
        this thread.
        """
        if self.guard.is_forked:
            self.guard.check('an RTPS writer')
        # hot path: the body of `Writer.write`, which saves a call
        otherwise: int | None = 0
        number = self.participant.run(partial(writer.add, payload, qos, to), otherwise)
        if number is not None or self.wire_poller.leads():
            return number
        deadline = monotonic() + writer.data.qos.max_blocking / NS
        sleeper = SleepingThread()
        self._sleepers.add(sleeper)
        try:
            while (number := writer.write(payload, qos=qos, to=to)) is None and not self._is_closed:
                left = deadline - monotonic()
                if left <= 0:
                    return None
                self.wire_poller.wait(sleeper, int(min(left, 1e6) * 1e9))
        finally:
            self._sleepers.discard(sleeper)
        return number

    def wait_until_acknowledged(self, timeout_s: float) -> bool:
        """Wait until reliable readers have acknowledged all samples; return False after `timeout_s`."""
        return self.wait_for_acknowledgements(self.participant.is_acknowledged, timeout_s)

    def wait_for_acknowledgements(self, is_done: Callable[[], bool], timeout_s: float) -> bool:
        """Check `is_done()` after each acknowledgement until it is true; return False after `timeout_s`."""
        if is_done():
            return True
        self.participant.ask_readers()
        deadline = monotonic() + timeout_s
        sleeper = SleepingThread()
        self._sleepers.add(sleeper)
        try:
            while not is_done():
                left = deadline - monotonic()
                if left <= 0:
                    return False
                self.wire_poller.wait(sleeper, int(min(left, 1e6) * 1e9))
        finally:
            self._sleepers.discard(sleeper)
        return True

    def _wake_sleepers(self) -> None:
        for sleeper in list(self._sleepers):
            sleeper.wake()

    # ---- the end

    def close(self) -> None:
        """Wait shortly for acknowledgements, tell others that the participant leaves, and close sockets."""
        if self._is_closed or self.guard.is_forked:
            return
        if not self.wire_poller.leads():
            self.wait_until_acknowledged(CLOSING_S)
        self._is_closed = True
        self.participant.close()
        self._wake_sleepers()
        self.wire_poller.close()
        self._poller.close()
        if self._changes is not None:
            self._changes.close()
        self._sockets.close()
