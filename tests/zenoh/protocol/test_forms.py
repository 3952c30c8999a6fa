"""Requests and replies that repeat are read by their form, with the same outcome as by the grammar."""

from __future__ import annotations

from typing import Any

from helpers.zenoh_protocol import Cable, Session
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.network import Target
from goalwire.zenoh.protocol.primitives import ZenohProtocolError
from goalwire.zenoh.protocol.querier import Querier
from goalwire.zenoh.protocol.queries import Answer

KEY = '0/add/T/H'
ATTACHMENT = bytes(33)
SIZES = st.sampled_from([0, 1, 4, 126, 127, 128, 16382, 16383, 16384, 70_000])
ATTACHMENTS = st.sampled_from([None, b'', b'a', ATTACHMENT, bytes(127), bytes(128)])


class Nothing(dict[bytes, Any]):
    """Remembers no form."""

    def __setitem__(self, key: bytes, form: object) -> None: ...


class Service:
    """A querier, a queryable that sends all back, and what both have seen."""

    def __init__(self, *, remembers: bool = True) -> None:
        one, other = Session(bytes(range(1, 17))), Session(b'\xa1\xa2')
        self.cable = Cable(one, other).start()
        if not remembers:
            for link in self.cable.links:
                link.request_forms = Nothing()
                link.reply_forms = Nothing()
        other.declare_queryable(KEY, self._answer, complete=True)
        self.cable.carry()
        self.queriers = [
            Querier(one, KEY, target=Target.ALL_COMPLETE),
            Querier(one, KEY, target=Target.ALL, parameters='a=b'),
        ]
        self.asked: list[tuple[str, bytes | None, bytes | None]] = []
        self.seen: list[object] = []

    def _answer(self, query: Query) -> None:
        payload = None if query.payload is None else bytes(query.payload)
        self.asked.append((query.parameters, payload, query.attachment))
        query.answer(KEY, payload or b'', query.attachment)

    def ask(self, payload: bytes | None, attachment: bytes | None, querier: int = 0) -> None:
        """Send a request, which does not arrive yet."""
        self.queriers[querier].ask(payload, attachment, self._note, lambda: self.seen.append('end'), 10.0)

    def _note(self, answer: Answer) -> None:
        assert isinstance(answer, Sample)
        assert answer.payload is not None
        self.seen.append((answer.key, bytes(answer.payload), answer.attachment))

    def deliver(self, to: int, data: bytes) -> str:
        """Hand bytes to one side; return how its link ended, if it did."""
        try:
            self.cable.links[to].frames.receive(data)
        except (ZenohProtocolError, ClosedByPeerError) as error:
            return str(error)
        return ''


def test_what_repeats_has_a_form_from_its_second_message_on() -> None:
    service = Service()
    for number in range(200):
        service.ask(b'%d' % number, ATTACHMENT)
        service.cable.carry()
    assert service.asked == [('', b'%d' % number, ATTACHMENT) for number in range(200)]
    assert service.seen == [
        each for number in range(200) for each in ((KEY, b'%d' % number, ATTACHMENT), 'end')
    ]
    one, other = service.cable.links
    assert len(one.reply_forms) == len(other.request_forms) == 1
    assert not one.request_forms
    assert not other.reply_forms


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(SIZES | st.none(), ATTACHMENTS, st.integers(0, 1)), max_size=30))
def test_both_ways_of_reading_see_the_same(calls: list[tuple[int | None, bytes | None, int]]) -> None:
    services = Service(), Service(remembers=False)
    for service in services:
        for size, attachment, querier in calls:
            service.ask(None if size is None else bytes(size), attachment, querier)
            service.cable.carry()
        assert service.cable.ends == [None, None]
        assert len(service.seen) == 2 * len(calls)
    assert services[0].asked == services[1].asked
    assert services[0].seen == services[1].seen


@settings(max_examples=300, deadline=None)
@given(
    to=st.integers(0, 1),
    size=st.sampled_from([0, 4, 130]),
    cut=st.integers(0, 3),
    changes=st.lists(st.tuples(st.integers(7, 400), st.integers(0, 255)), max_size=3),
)
def test_both_ways_of_reading_refuse_the_same(
    to: int, size: int, cut: int, changes: list[tuple[int, int]]
) -> None:
    outcomes = []
    for service in (Service(), Service(remembers=False)):
        for _ in range(2):
            service.ask(bytes(4), ATTACHMENT)
            service.cable.carry()
        service.ask(bytes(size), ATTACHMENT)
        batch = service.cable.wires[0].take()
        if to == 0:
            assert service.deliver(1, batch) == ''
            batch = service.cable.wires[1].take()
        changed = bytearray(batch[: len(batch) - cut])
        changed[:2] = (len(changed) - 2).to_bytes(2, 'little')
        for at, byte in changes:
            if at < len(changed):
                changed[at] = byte
        end = service.deliver(to, bytes(changed))
        outcomes.append((bool(end), service.asked, service.seen))
    assert outcomes[0] == outcomes[1]
