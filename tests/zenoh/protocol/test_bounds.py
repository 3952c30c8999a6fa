"""A session keeps and compares for a peer only what is within bounds; it counts and ignores the rest."""

from __future__ import annotations

from time import perf_counter

import pytest
from helpers.zenoh_protocol import Cable, Session, pair

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.bodies import Sample, put_body
from goalwire.zenoh.protocol.channels import DATA_CHANNEL
from goalwire.zenoh.protocol.declarations import (
    About,
    Kind,
    When,
    declare,
    declare_expression,
    interest,
    take_back,
)
from goalwire.zenoh.protocol.key_expressions import includes, intersects
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import LinkStates, Node, tell_of
from goalwire.zenoh.protocol.network import push_head, wire_key
from goalwire.zenoh.protocol.primitives import Reader, ZenohProtocolError

QUICK_S = 0.5
"""Each of these comparisons took seconds or minutes before; now they take less than a millisecond."""


def attack(role: Role = Role.PEER) -> tuple[Session, Cable]:
    """Return a session and its link to a stranger, which is the other end of the cable."""
    session, _, cable = pair(Role.PEER, role)
    return session, cable


def says(cable: Cable, *messages: bytes) -> None:
    """Have the stranger say network messages."""
    for message in messages:
        cable.links[1].outgoing.send(DATA_CHANNEL, message)
    cable.carry()


def put(key: str, payload: bytes = b'x') -> bytes:
    return push_head(wire_key(key), 5) + put_body(payload)


@pytest.mark.parametrize(
    ('one', 'other'),
    [
        ('$*a' * 20_000, 'a' * 40_000 + 'b'),
        ('$*a' * 20_000 + 'c', '$*a' * 20_000 + '$*b'),
        ('a$*' * 20_000, 'a' * 20_000 + '$*'),
    ],
)
def test_chunks_of_any_size_are_compared_in_no_time(one: str, other: str) -> None:
    began = perf_counter()
    for first, second in ((one, other), (other, one)):
        intersects(f'k/{first}', f'k/{second}')
        includes(f'k/{first}', f'k/{second}')
    assert perf_counter() - began < QUICK_S


@pytest.mark.parametrize(
    'key', ['k' * (bounds.KEY_LIMIT + 1), 'k/' + '$*a' * (bounds.WILD_SIGNS + 1), '*/' * 40 + 'k']
)
def test_a_key_beyond_the_bounds_is_ignored_wherever_it_stands(key: str) -> None:
    session, cable = attack(Role.CLIENT)
    session.declare_subscriber('**', lambda _: None)
    says(
        cable,
        declare(Kind.SUBSCRIBER, 900, wire_key(key)),
        declare(Kind.TOKEN, 901, wire_key(key)),
        interest(902, When.FUTURE, About.ALL, key),
        put(key),
    )
    link = cable.links[0]
    assert session.refused == ['key'] * 4
    assert [*link.peer.tokens, *link.push_receivers] == []
    assert 902 not in link.peer.interests
    assert 900 not in link.peer.subscribers
    assert cable.ends == [None, None]


def test_a_key_put_together_from_an_id_and_a_suffix_has_the_same_bound() -> None:
    session, cable = attack()
    says(cable, declare_expression(900, 'k' * bounds.KEY_LIMIT))
    link = cable.links[0]
    assert link.peer.key_of(900, b'', 1) is not None
    assert link.peer.key_of(900, b'/k', 1) is None
    assert session.refused == ['key']


def test_long_keys_are_delivered_but_not_remembered() -> None:
    session, cable = attack()
    came: list[Sample] = []
    session.declare_subscriber('**', came.append)
    keys = ['k' * 20, 'k' * (bounds.KEPT_KEY + 1)]
    says(cable, *map(put, keys))
    assert [each.key for each in came] == keys
    assert [where[2] for where in cable.links[0].push_receivers if isinstance(where, tuple)] == [b'k' * 20]


def test_what_a_link_declares_has_a_bound_that_taking_back_undoes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'DECLARED_LIMIT', 10 * (bounds.DECLARED_COST + 3))
    session, cable = attack()
    link = cable.links[0]
    kinds = [Kind.TOKEN, Kind.SUBSCRIBER, Kind.QUERYABLE]
    says(cable, *(declare(kinds[at % 3], 900 + at, wire_key(f'k{at:02}')) for at in range(12)))
    assert len(link.peer.tokens) + len(link.peer.subscribers) + len(link.peer.queryables) == 10
    assert session.refused == ['declaration'] * 2
    says(cable, *(take_back(kinds[at % 3], 900 + at) for at in range(12)))
    assert link.peer.size == 0
    says(cable, declare_expression(900, 'abc'), declare(Kind.TOKEN, 901, wire_key('abc')))
    says(
        cable, declare(Kind.SUBSCRIBER, 902, wire_key('abc')), declare(Kind.SUBSCRIBER, 902, wire_key('abd'))
    )
    assert link.peer.size == 3 * (bounds.DECLARED_COST + 3)


def test_interests_are_counted_once_for_each_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'MOST_INTERESTS', 3)
    session, cable = attack(Role.CLIENT)
    link = cable.links[0]
    before = link.peer.size
    says(cable, *(interest(900 + at % 4, When.FUTURE, About.ALL, 'a/b') for at in range(8)))
    assert len(link.peer.interests) == 3
    assert link.peer.size == before + 2 * (bounds.DECLARED_COST + 3)
    assert set(session.refused) == {'interest'}


def test_expressions_that_are_compared_one_by_one_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'MOST_WILD', 3)
    session, cable = attack()
    link = cable.links[0]
    says(cable, *(declare(Kind.SUBSCRIBER, 900 + at, wire_key(f'*/k{at}')) for at in range(5)))
    says(cable, *(declare(Kind.SUBSCRIBER, 950 + at, wire_key(f'k{at}/**')) for at in range(50)))
    assert session.refused == ['declaration'] * 2
    assert len(link.peer.subscribers) == 53
    assert [key for key, _ in link.peer.subscribers.meeting('k7/a/b')] == ['k7/**']


def test_the_oldest_node_without_a_link_makes_room_for_a_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'MOST_NODES', 3)
    session, cable = attack(Role.ROUTER)
    nodes = [Node(bytes((1, at + 1)), Role.PEER, ('tcp/localhost:1',) * 20) for at in range(5)]
    for at, node in enumerate([Node(b'\xa1\xa2', Role.ROUTER, ('tcp/localhost:1',)), *nodes]):
        session.take_nodes(cable.links[0], LinkStates().read(Reader(tell_of(node, at))))
    assert list(session.gossip.nodes) == [b'\xa1\xa2', nodes[3].zid, nodes[4].zid]
    assert session.refused == ['node of gossip'] * 3
    assert all(len(node.locators) <= bounds.MOST_LOCATORS for node in session.to_meet)


def test_whoever_asks_on_without_reading_loses_its_link(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'UNREAD_LIMIT', 3 << 20)
    server, client, cable = pair()
    server.declare_queryable('k', lambda query: query.answer('k', bytes(1 << 20)), complete=True)
    cable.carry()
    cable.wires[0].room = 0
    for _ in range(6):
        cable.links[1].outgoing.send(DATA_CHANNEL, REQUEST_FOR_K)
        cable.carry()
    assert isinstance(cable.ends[0], ZenohProtocolError)
    assert 'leaves over 3 MiB of answers unread' in str(cable.ends[0])
    assert cable.wires[0].waits <= 1  # the last answer, which was beyond the limit
    assert client.refused == server.refused == []


REQUEST_FOR_K = bytes.fromhex('bc 01 00 01 6b 21 0d 03')
"""A REQUEST for the key k, whose answers are not to be dropped."""


def test_an_unfinished_message_is_given_up_after_a_while() -> None:
    session, cable = attack()
    link, far = cable.links
    far.outgoing.send(DATA_CHANNEL, put('k', bytes(200_000)))
    pieces = cable.wires[1].take()
    link.frames.receive(pieces[:140_000])
    assert session.pieces.used > 100_000
    session.time.now += 1
    assert link.frames.discard_stale(session.time()) == 0
    session.time.now += bounds.STALE_S
    assert link.frames.discard_stale(session.time()) > 100_000
    assert session.pieces.used == 0
    assert session.refused == ['message in pieces']
    link.frames.receive(pieces[140_000:])
    far.outgoing.send(DATA_CHANNEL, put('k'))
    cable.carry()
    assert cable.ends == [None, None]
