"""Writes on `pong` what comes on `ping`, until it is killed; the domain is the argument."""

from __future__ import annotations

import sys
from threading import Event

from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.rtps.io.session import RtpsSession, Settings
from goalwire.rtps.protocol.qos import RELIABLE, Qos
from goalwire.rtps.protocol.reader import ReaderListener, Sample
from goalwire.rtps.protocol.writer import WriterListener

session = RtpsSession(Settings(domain=int(sys.argv[1]), lease_s=1.0))
qos = Qos(reliability=RELIABLE, depth=10)
writer = session.participant.create_writer('pong', 'T', qos, WriterListener())


class Echo(ReaderListener):
    """Answers on the thread that reads."""

    def on_sample(self, sample: Sample) -> None:
        writer.write(bytes(sample.payload or b''))


session.participant.create_reader('ping', 'T', qos, Echo())
print('ready', flush=True)
if 'idle' in sys.argv:  # nobody but the session's own thread reads
    Event().wait()
while True:
    session.wire_poller.wait(SleepingThread(), 10**9)
