"""A signal's handler makes writers and readers while its own thread is just at the same participant."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest
from helpers.interrupting import at_each_line
from helpers.rtps_network import Collector, Network, Publisher

from goalwire.records import replace
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.primitives import NS
from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL, Qos

LATCHED = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL, depth=0)
IN_TIME = replace(LATCHED, deadline=NS)
MAIN, HANDLER = b'\0\1\0\0main', b'\0\1\0\0hand'


def write(participant: Participant) -> None:
    participant.create_writer('main', 'T', LATCHED, Publisher()).write(MAIN)


def read(participant: Participant) -> None:
    participant.create_reader('other', 'T', LATCHED, Collector())


@pytest.mark.parametrize('action', [write, read])
def test_what_a_handler_makes_works_wherever_it_comes(action: Callable[[Participant], None]) -> None:
    for interruption in at_each_line():
        network = Network()
        one, _ = network.participant()
        other, _ = network.participant()
        far = {topic: Collector() for topic in ('main', 'handler')}
        for topic, collector in far.items():
            other.create_reader(topic, 'T', LATCHED, collector)
        other.create_writer('answer', 'T', LATCHED, Publisher()).write(HANDLER)
        network.run(0.5)
        publisher, near = Publisher(), Collector()

        def handle(
            participant: Participant = one, publisher: Publisher = publisher, near: Collector = near
        ) -> None:
            participant.create_reader('answer', 'T', LATCHED, near)
            participant.create_writer('handler', 'T', IN_TIME, publisher).write(HANDLER)

        interruption.run(partial(action, one), handle)
        network.run(1.5)
        expected = [HANDLER] if interruption.place else []
        assert far['handler'].payloads == near.payloads == expected, interruption.place
        assert publisher.missed_deadlines == len(expected), interruption.place
        assert far['main'].payloads == ([MAIN] if action is write else []), interruption.place
