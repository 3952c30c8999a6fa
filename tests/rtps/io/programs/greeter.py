"""Greets everybody, itself too, and prints who greets and who has gone.

The arguments are its name, and fields of Settings as JSON.
"""

from __future__ import annotations

import json
import sys

from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.rtps.io.addresses import Reach
from goalwire.rtps.io.session import RtpsSession, Settings
from goalwire.rtps.protocol.announcements import EndpointData, ParticipantData
from goalwire.rtps.protocol.discovery import ParticipantListener
from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL, Qos
from goalwire.rtps.protocol.reader import ReaderListener, Sample
from goalwire.rtps.protocol.writer import WriterListener

name, fields = sys.argv[1], json.loads(sys.argv[2])
fields = {key: tuple(value) if isinstance(value, list) else value for key, value in fields.items()}
fields['reach'] = Reach(fields.get('reach', 'subnet'))


class Watcher(ParticipantListener):
    def on_participant(self, participant: ParticipantData) -> None:
        hosts = ' '.join(sorted(host for host, _ in participant.metatraffic))
        print(f'at {hosts}', flush=True)


class Greetings(ReaderListener):
    def on_sample(self, sample: Sample) -> None:
        assert sample.payload is not None
        print(f'greeted by {sample.payload[4:].rstrip(bytes(1)).decode()}', flush=True)

    def on_unmatched(self, writer: EndpointData) -> None:
        print('left', flush=True)


session = RtpsSession(Settings(**fields), Watcher())
qos = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL, depth=10)
writer = session.participant.create_writer('greetings', 'T', qos, WriterListener())
session.participant.create_reader('greetings', 'T', qos, Greetings())
writer.write(b'\0\1\0\0' + name.encode())
sleeper = SleepingThread()
while True:
    session.wire_poller.wait(sleeper, 10**9)
