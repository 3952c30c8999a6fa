"""A signal's handler publishes, asks and declares while its own thread is just at it: nothing is lost."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial

import pytest
from helpers.interrupting import at_each_call, at_each_line
from helpers.zenoh_protocol import Session, pair

from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.primitives import decode_z
from goalwire.zenoh.protocol.publication import FLOOD, Publication
from goalwire.zenoh.protocol.querier import Querier
from goalwire.zenoh.protocol.queries import Answer
from goalwire.zenoh.protocol.stamps import Stamps


class Linked:
    """Two sessions; the second one notes what the first one puts and asks."""

    def __init__(self, *, holds_back: bool = False) -> None:
        Session.holds_back = holds_back
        try:
            self.one, self.other, self.cable = pair(batch_size=2000)
        finally:
            Session.holds_back = False
        self.heard: list[tuple[str, bytes]] = []
        self.other.declare_subscriber('**', self._hear)
        self.other.declare_queryable('q', self._answer, complete=True)
        self.cable.carry()

    def _hear(self, sample: Sample) -> None:
        self.heard.append((sample.key, bytes(sample.payload or b'')))

    def _answer(self, query: Query) -> None:
        query.answer('q', query.payload or b'')

    def settle(self) -> None:
        """Have everything arrive."""
        link, wire = self.cable.links[0], self.cable.wires[0]
        wire.room = None
        link.outgoing.release()
        link.outgoing.flush()
        self.cable.carry()
        assert self.cable.ends == [None, None]
        assert not self.one.failures + self.other.failures


def put_first(linked: Linked) -> Callable[[], object]:
    """The first message on a key, whose number is told before."""
    publication = Publication(linked.one, 'a')
    return lambda: publication.put(b'main')


def put_again(linked: Linked) -> Callable[[], object]:
    publication = Publication(linked.one, 'a')
    publication.put(b'before')
    return lambda: publication.put(b'main')


def put_large(linked: Linked) -> Callable[[], object]:
    """A message in pieces, which nothing may come between."""
    publication = Publication(linked.one, 'a')
    return lambda: publication.put(b'main' + bytes(5_000))


def put_into_a_full_socket(linked: Linked) -> Callable[[], object]:
    """A message of which the socket takes a part."""
    publication = Publication(linked.one, 'a')
    publication.put(b'before')
    linked.cable.wires[0].room = 7
    return lambda: publication.put(b'main')


def put_behind_what_waits(linked: Linked) -> Callable[[], object]:
    publication = Publication(linked.one, 'a')
    linked.cable.wires[0].room = 0
    publication.put(b'before')
    return lambda: publication.put(b'main')


def flush(linked: Linked) -> Callable[[], object]:
    """Messages that waited go out, a few bytes at a time."""
    publication = Publication(linked.one, 'a')
    wire = linked.cable.wires[0]
    wire.room = 0
    for _ in range(3):
        publication.put(b'main')
    wire.room = 9

    def write() -> None:
        linked.cable.links[0].outgoing.flush()
        wire.room = 20
        linked.cable.links[0].outgoing.flush()

    return write


def put_in_a_flood(linked: Linked) -> Callable[[], object]:
    """Messages that wait to go out together."""
    publication = Publication(linked.one, 'a')
    linked.one.stamps.burst = 2 * FLOOD

    def put_two() -> None:
        publication.put(b'main')
        publication.put(b'main')
        linked.cable.links[0].outgoing.release()

    return put_two


def say_that_it_lives(linked: Linked) -> Callable[[], object]:
    linked.cable.links[0].outgoing.tick()
    return linked.cable.links[0].outgoing.tick


def declare(linked: Linked) -> Callable[[], object]:
    """Declare on the very key that the handler publishes on."""
    return lambda: linked.one.undeclare(linked.one.declare_subscriber('b', lambda _: None))


def take_back_a_key(linked: Linked) -> Callable[[], object]:
    publication = Publication(linked.one, 'b')
    publication.put(b'before')
    return publication.close


def take_a_declaration(linked: Linked) -> Callable[[], object]:
    """A declaration of the other side arrives."""
    linked.other.declare_subscriber('b', lambda _: None)
    return linked.cable.carry


HANDLERS = [b'1', b'2' + bytes(3000), b'3']
ACTIONS = [
    put_first,
    put_again,
    put_large,
    put_into_a_full_socket,
    put_behind_what_waits,
    flush,
    put_in_a_flood,
    say_that_it_lives,
    declare,
    take_back_a_key,
    take_a_declaration,
]


class Handler:
    """Puts a small message, one in pieces and a small one; and asks."""

    def __init__(self, linked: Linked) -> None:
        self._publication = Publication(linked.one, 'b')
        self._querier = Querier(linked.one, 'q')
        self.answers: list[bytes] = []
        self.ends = 0

    def __call__(self) -> None:
        for payload in HANDLERS:
            self._publication.put(payload)
        self._querier.ask(b'?', b'', self._answered, self._ended, 9.0)

    def _answered(self, answer: Answer) -> None:
        self.answers.append(bytes(answer.payload or b''))

    def _ended(self) -> None:
        self.ends += 1


def prepared(prepare: Callable[[Linked], Callable[[], object]]) -> tuple[Linked, Callable[[], object]]:
    linked = Linked(holds_back=prepare is put_in_a_flood)
    return linked, prepare(linked)


@pytest.mark.parametrize('prepare', ACTIONS)
def test_nothing_is_lost_wherever_a_handler_comes(prepare: Callable[[Linked], Callable[[], object]]) -> None:
    linked, action = prepared(prepare)
    action()
    linked.settle()
    undisturbed = linked.heard
    for interruption in at_each_line():
        linked, action = prepared(prepare)
        handler = Handler(linked)
        interruption.run(action, handler)
        linked.settle()
        handlers = [each for each in linked.heard if each[1] in HANDLERS]
        if interruption.place:
            assert handlers == [('b', payload) for payload in HANDLERS], interruption.place
            assert (handler.answers, handler.ends) == ([b'?'], 1), interruption.place
        assert [each for each in linked.heard if each not in handlers] == undisturbed, interruption.place
        assert not linked.one.queries.pending, interruption.place


class RaisedError(Exception):
    """The exception that a signal's handler raises."""


def raises() -> None:
    raise RaisedError


@pytest.mark.parametrize('prepare', ACTIONS)
def test_a_handler_that_raises_leaves_the_link_whole_wherever_it_comes(
    prepare: Callable[[Linked], Callable[[], object]],
) -> None:
    """An interrupted message may be lost; no message arrives in part or twice, and those after it arrive."""
    linked, action = prepared(prepare)
    action()
    linked.settle()
    undisturbed = linked.heard
    for interruption in at_each_call():
        linked, action = prepared(prepare)
        with suppress(RaisedError):
            interruption.run(action, raises)
        later = Publication(linked.one, 'z')
        for payload in HANDLERS:
            later.put(payload)
        linked.settle()
        heard = list(undisturbed)
        for each in linked.heard[: -len(HANDLERS)]:
            assert each in heard, interruption.place
            heard.remove(each)
        assert linked.heard[-len(HANDLERS) :] == [('z', payload) for payload in HANDLERS], interruption.place
        assert not linked.cable.links[0].outgoing.queue.size, interruption.place


def test_what_a_handler_declares_is_known_wherever_it_comes() -> None:
    for interruption in at_each_line():
        linked = Linked()
        heard: list[Sample] = []
        tokens: list[Sample] = []
        linked.other.watch_tokens('*', tokens.append, history=True)
        interruption.run(partial(declare_for_a_moment, linked.one), partial(declare_all, linked.one, heard))
        linked.settle()
        Publication(linked.other, 'x').put(b'1')
        linked.settle()
        assert len(heard) == len(tokens) == bool(interruption.place), interruption.place


def declare_for_a_moment(session: Session) -> None:
    session.undeclare(session.declare_subscriber('x', lambda _: None))


def declare_all(session: Session, heard: list[Sample]) -> None:
    session.declare_subscriber('x', heard.append)
    session.declare_token('u')


@pytest.mark.parametrize('passed_ns', [0, 4_000, 70_000_000, -70_000_000])
def test_stamps_are_each_later_wherever_a_handler_makes_one(passed_ns: int) -> None:
    for interruption in at_each_call():
        now = [1_700_000_000_000_000_000]
        stamps = Stamps(b'\xa1', partial(now.__getitem__, 0))
        out = [stamps.next()]
        now[0] += passed_ns
        of_handler: list[bytes] = []
        interruption.run(partial(make_one, stamps, out), partial(make_one, stamps, of_handler))
        make_one(stamps, out)
        first, own, last = (decode_z(each, 0)[0] for each in out)
        assert first < own < last, interruption.place
        assert all(first < decode_z(each, 0)[0] < last and each != out[1] for each in of_handler)


def make_one(stamps: Stamps, out: list[bytes]) -> None:
    out.append(stamps.next())
