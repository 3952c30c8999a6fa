"""Sends numbered samples of mixed sizes, or reads them and tells whether all came in order.

stream.py write|read NUMBER PEER RELIABILITY
"""

from __future__ import annotations

import sys
from time import monotonic

from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.rtps.io.addresses import Reach
from goalwire.rtps.io.session import RtpsSession, Settings
from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.qos import BEST_EFFORT, RELIABLE, Qos
from goalwire.rtps.protocol.reader import ReaderListener, Sample
from goalwire.rtps.protocol.writer import WriterListener

role, number, peer, reliability = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4]
is_reliable = reliability == 'reliable'
qos = Qos(reliability=BEST_EFFORT, depth=10)
if is_reliable:
    qos = Qos(reliability=RELIABLE, depth=0, max_blocking=10**11)
session = RtpsSession(Settings(reach=Reach.SUBNET, peers=(peer,)))
sleeper = SleepingThread()


def payload_of(at: int) -> bytes:
    """Return the sample of a number; every twentieth is large."""
    return b'\0\1\0\0' + at.to_bytes(4, 'little') + bytes([at & 0xFF]) * (30_000 if at % 20 == 0 else 64)


class Wake(WriterListener):
    def on_matched(self, reader: EndpointData) -> None:
        sleeper.wake()


class Check(ReaderListener):
    def __init__(self) -> None:
        self.count = 0
        self.last = -1
        self.wrong = 0

    def on_sample(self, sample: Sample) -> None:
        payload = sample.payload or b''
        at = int.from_bytes(payload[4:8], 'little')
        is_next = at == self.count if is_reliable else at > self.last
        self.wrong += not is_next or payload != payload_of(at)
        self.count, self.last = self.count + 1, at
        if self.last >= number - 1:
            sleeper.wake()


if role == 'write':
    writer = session.participant.create_writer('stream', 'T', qos, Wake())
    while not writer.readers:
        session.wire_poller.wait(sleeper, 10**9)
    print('met', flush=True)
    longest = 0.0
    for at in range(number):
        begun = monotonic()
        assert session.write(writer, payload_of(at)) is not None
        longest = max(longest, monotonic() - begun)
        if not is_reliable:
            session.wire_poller.wait(sleeper, 1_000_000)
    print(f'longest {longest:.3f}', flush=True)
    while not is_reliable:  # any of these may be the first that comes again
        at += 1
        session.write(writer, payload_of(at))
        session.wire_poller.wait(sleeper, 1_000_000)
    print(f'acknowledged {session.wait_until_acknowledged(100)}', flush=True)
    while True:
        session.wire_poller.wait(sleeper, 10**9)
check = Check()
session.participant.create_reader('stream', 'T', qos, check)
while check.last < number - 1:
    session.wire_poller.wait(sleeper, 10**9)
print(f'{check.count} came, {check.wrong} wrong', flush=True)
while True:
    session.wire_poller.wait(sleeper, 10**9)
