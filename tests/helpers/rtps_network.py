"""Participants on a simulated network, in virtual time: packets are lost, doubled, delayed and overtaken."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable
from itertools import count
from random import Random

from goalwire.rtps.protocol.announcements import EndpointData, ParticipantData
from goalwire.rtps.protocol.discovery import ParticipantListener, Settings
from goalwire.rtps.protocol.identity import RANDOM_SIZE, make_prefix
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.primitives import Address
from goalwire.rtps.protocol.reader import ReaderListener, Sample
from goalwire.rtps.protocol.writer import WriterListener

EPOCH_NS = 1_700_000_000 * 10**9


class Watcher(ParticipantListener):
    """Remembers who is there."""

    def __init__(self) -> None:
        self.participants: dict[bytes, ParticipantData] = {}
        self.endpoints: dict[bytes, EndpointData] = {}
        self.refused: Counter[str] = Counter()

    def on_participant(self, participant: ParticipantData) -> None:
        self.participants[participant.prefix] = participant

    def on_participant_lost(self, participant: ParticipantData) -> None:
        del self.participants[participant.prefix]

    def on_endpoint(self, endpoint: EndpointData) -> None:
        self.endpoints[endpoint.guid] = endpoint

    def on_endpoint_lost(self, endpoint: EndpointData) -> None:
        del self.endpoints[endpoint.guid]

    def on_refused(self, kind: str, reason: str) -> None:
        self.refused[kind] += 1


class Collector(ReaderListener):
    """Remembers what a reader has been given."""

    def __init__(self) -> None:
        self.samples: list[Sample] = []
        self.matched: list[bytes] = []
        self.answered: list[bytes] = []
        """The reliable writers that know the reader: what they write from now on comes."""
        self.incompatible: list[str] = []
        self.lost = 0
        self.missed_deadlines = 0
        self.liveliness: list[bool] = []
        self.on_any: Callable[[Sample], None] = lambda _: None

    @property
    def payloads(self) -> list[bytes | None]:
        """The payloads that have come, in order."""
        return [None if sample.payload is None else bytes(sample.payload) for sample in self.samples]

    @property
    def last(self) -> bytes | bytearray | None:
        """The payload that came last; None if nothing has come. It costs less than all of them."""
        return self.samples[-1].payload if self.samples else None

    def on_sample(self, sample: Sample) -> None:
        self.samples.append(sample)
        self.on_any(sample)

    def on_matched(self, writer: EndpointData) -> None:
        self.matched.append(writer.guid)

    def on_answered(self, writer: EndpointData) -> None:
        self.answered.append(writer.guid)

    def on_unmatched(self, writer: EndpointData) -> None:
        self.matched.remove(writer.guid)

    def on_incompatible(self, writer: EndpointData, policy: str) -> None:
        self.incompatible.append(policy)

    def on_lost(self, count: int) -> None:
        self.lost += count

    def on_deadline_missed(self) -> None:
        self.missed_deadlines += 1

    def on_liveliness(self, writer: bytes, is_alive: bool) -> None:
        self.liveliness.append(is_alive)


class Publisher(WriterListener):
    """Remembers what a writer is told."""

    def __init__(self) -> None:
        self.matched: list[bytes] = []
        self.incompatible: list[str] = []
        self.missed_deadlines = 0
        self.lost_liveliness = 0
        self.room = 0
        self.on_any_room: Callable[[], None] = lambda: None

    def on_matched(self, reader: EndpointData) -> None:
        self.matched.append(reader.guid)

    def on_unmatched(self, reader: EndpointData) -> None:
        self.matched.remove(reader.guid)

    def on_incompatible(self, reader: EndpointData, policy: str) -> None:
        self.incompatible.append(policy)

    def on_deadline_missed(self) -> None:
        self.missed_deadlines += 1

    def on_liveliness_lost(self) -> None:
        self.lost_liveliness += 1

    def on_room(self) -> None:
        self.room += 1
        self.on_any_room()


class Network:
    """Hosts 10.0.0.1, 10.0.0.2 and so on, each with one participant, and what goes wrong between them."""

    def __init__(self, seed: int = 0, *, loss: float = 0, double: float = 0, delay_s: float = 0.0) -> None:
        """`loss` and `double` are shares of packets; each takes 50 µs and up to `delay_s` longer."""
        self.now = 0.0
        self.loss, self.double, self.delay = loss, double, delay_s
        self.random = Random(seed)
        self.packets: list[tuple[float, Address, Address, bytes]] = []
        """The packets that were sent: time, sender, receiver, bytes."""
        self.keeps = False
        self.sent = 0
        self.cut: Callable[[str, str], bool] = lambda _from, _to: False
        """Whether nothing gets from one host to another."""
        self._queue: list[tuple[float, int, Callable[[], None]]] = []
        self._next = count().__next__
        self._hosts: dict[str, Participant] = {}

    def participant(
        self,
        *,
        same_host: bool = False,
        settings: dict[str, object] | None = None,
        starts: bool = True,
    ) -> tuple[Participant, Watcher]:
        """Make one more participant, known to all others from its start on."""
        number = len(self._hosts) + 1
        host = f'10.0.0.{number}'
        address = host, 7410
        chosen = Settings(
            **{
                'prefix': make_prefix(address[1], number.to_bytes(RANDOM_SIZE, 'big')),
                'metatraffic': (address,),
                'default': (address,),
                'peers': tuple(
                    (other, 7410) for other in (f'10.0.0.{n}' for n in range(1, 9)) if other != host
                ),
                'own_hosts': frozenset(f'10.0.0.{n}' for n in range(1, 99))
                if same_host
                else frozenset({host}),
                **(settings or {}),
            }  # type: ignore[arg-type]
        )
        watcher = Watcher()
        made = Participant(
            chosen,
            watcher,
            clock=lambda: self.now,
            wall_clock_ns=lambda: EPOCH_NS + int(self.now * 1e9),
            send=lambda packet, to: self.send(packet, address, to),
        )
        self._hosts[host] = made
        if starts:
            made.start()
        return made, watcher

    def send(self, packet: bytes, source: Address, to: Address) -> None:
        """Take a packet on its way."""
        self.sent += 1
        if self.keeps:
            self.packets.append((self.now, source, to, packet))
        if to[0] not in self._hosts or self.cut(source[0], to[0]):
            return
        random = self.random
        for _ in range(1 + (random.random() < self.double)):
            if random.random() >= self.loss:
                delay = 50e-6 + random.random() * self.delay
                self.at(self.now + delay, lambda: self._hosts[to[0]].receive(packet, source))

    def at(self, when: float, do: Callable[[], None]) -> None:
        """Have something done at a time."""
        heapq.heappush(self._queue, (when, self._next(), do))

    def run(self, seconds: float, until: Callable[[], object] = lambda: False) -> bool:
        """Let time pass; ends early, and returns True, once `until` holds."""
        end = self.now + seconds
        while not until():
            due, host = min((one.timers.next_due(), host) for host, one in self._hosts.items())
            if self._queue and self._queue[0][0] <= due:
                due = self._queue[0][0]
                if due > end:
                    break
                self.now = max(self.now, due)
                heapq.heappop(self._queue)[2]()
            elif due > end:
                break
            else:
                self.now = max(self.now, due)
                self._hosts[host].advance()
        else:
            return True
        self.now = end
        return False
