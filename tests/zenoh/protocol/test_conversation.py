"""A captured conversation of two eclipse-zenoh peers: each side of it is played by a session of ours."""

from __future__ import annotations

import pytest
from helpers.zenoh_captured import Batch, conversation
from helpers.zenoh_protocol import Session, Wire

from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.network import ReplyError
from goalwire.zenoh.protocol.queries import PendingQuery

A, B = bytes.fromhex('a1a2a3a4'), bytes.fromhex('b1b2b3b4')
ATTACHMENT = bytes(range(33))
BATCHES = conversation()


def said_by(sender: str) -> list[Batch]:
    return [batch for batch in BATCHES if batch.sender == sender]


def listen_to(sender: str) -> tuple[Session, Link, Wire]:
    """Return a session in the place of the other side, linked as far as the handshake."""
    session = Session(B if sender == 'A' else A)
    link, wire = session.new_link(connects=sender == 'A')
    if sender == 'B':  # our cookie differs from the captured one, so that is put in its place
        init, opening = said_by('B')[:2]
        link.frames.receive(init.sent)
        ours = wire.take()
        cookie = ours[-19:-3]
        captured = opening.data[opening.data.index(b'\x21') + 1 :]
        link.frames.receive(
            opening._replace(data=opening.data.replace(b'\x21' + captured, b'\x10' + cookie)).sent
        )
    else:
        link.start()
        for batch in said_by('A')[:2]:
            link.frames.receive(batch.sent)
    wire.take()
    return session, link, wire


def test_what_a_peer_declares_and_takes_back() -> None:
    session, link, _ = listen_to('A')
    tokens: list[Sample] = []
    session.watch_tokens('@ros2_lv/0/**', tokens.append, history=True)
    for batch in said_by('A')[2:4]:
        link.frames.receive(batch.sent)
    assert link.peer.expressions == {1: '0/chatter/T/H', 2: '0/srv/T/H', 3: '@ros2_lv/0/a/SS'}
    assert link.peer.subscribers.all() == [(1, '0/chatter/T/H', None)]
    assert link.peer.queryables.all() == [(2, '0/srv/T/H', (True, 0))]
    assert [(sample.key, sample.payload) for sample in tokens] == [('@ros2_lv/0/a/SS', b'')]
    assert link.peer.knows_all
    for batch in said_by('A')[4:-1]:
        link.frames.receive(batch.sent)
    assert [(sample.key, sample.payload) for sample in tokens[1:]] == [('@ros2_lv/0/a/SS', None)]
    with pytest.raises(ClosedByPeerError, match='reason 0'):
        link.frames.receive(said_by('A')[-1].sent)


def test_replies_errors_and_their_ends() -> None:
    session, link, _ = listen_to('A')
    answers: list[object] = []
    for batch in said_by('A')[2:]:
        if batch.says.startswith('response 1'):
            query = PendingQuery(
                '0/srv/T/H',
                b'0/srv/T/H',
                [link],
                1e9,
                answers.append,
                lambda: answers.append('end'),
                takes_any_key=False,
            )
            assert session.queries.add(query) == 1
        if batch.says.startswith('response 2'):
            query = PendingQuery(
                '0/srv/T/H',
                b'0/srv/T/H',
                [link],
                1e9,
                answers.append,
                lambda: answers.append('end'),
                takes_any_key=False,
            )
            assert session.queries.add(query) == 2
        if batch.says != 'close':
            link.frames.receive(batch.sent)
    first = Sample('0/srv/T/H', bytes.fromhex('0001000001000000'), ATTACHMENT)
    assert isinstance(answers[0], Sample)
    assert answers[0]._replace(stamp=None) == first
    assert answers[1:] == ['end', ReplyError(b'no'), 'end']
    assert session.queries.pending == {}


def test_messages_and_queries_as_a_peer_sends_them() -> None:
    session, link, wire = listen_to('B')
    samples: list[Sample] = []
    queries: list[Query] = []
    tokens: list[Sample] = []
    session.declare_subscriber('0/chatter/T/H', samples.append)
    session.declare_queryable('0/srv/T/H', queries.append, complete=True)
    session.watch_tokens('@ros2_lv/0/**', tokens.append, history=True)
    wire.take()
    for batch in said_by('B')[2:]:
        link.frames.receive(batch.sent)
    hello, deleted, real_time = samples
    assert (hello.key, hello.payload) == ('0/chatter/T/H', b'hello')
    assert hello.attachment is not None
    assert hello.attachment == bytes(range(33))
    assert hello.timestamp is not None
    assert hello.timestamp.zid == B
    assert deleted.payload is None
    assert real_time.payload == b'rt'
    assert [(query.key, query.parameters) for query in queries] == [('0/srv/T/H', ''), ('0/srv/T/H', 'x')]
    assert queries[0].payload == bytes.fromhex('0001000001000000')
    assert queries[0].attachment == ATTACHMENT
    assert queries[1].payload is None
    assert [(token.key, token.payload) for token in tokens] == [
        ('@ros2_lv/0/b/SC', b''),
        ('@ros2_lv/0/b/SC', None),
    ]
