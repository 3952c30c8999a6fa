"""The session protocol decides who gets what: declarations, routes, queries, tokens, gossip."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.zenoh_protocol import Cable, Session, pair

from goalwire.zenoh.protocol.bodies import Consolidation, Sample
from goalwire.zenoh.protocol.declarations import About, When, interest
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import LinkStates, Node, connects_to, tell_of
from goalwire.zenoh.protocol.network import ReplyError, Target
from goalwire.zenoh.protocol.primitives import Reader
from goalwire.zenoh.protocol.publication import Publication
from goalwire.zenoh.protocol.querier import Querier
from goalwire.zenoh.protocol.queries import TIMEOUT


class Heard:
    """The samples that a subscriber or a watcher was told."""

    def __init__(self) -> None:
        self.samples: list[Sample] = []

    def __call__(self, sample: Sample) -> None:
        self.samples.append(sample)

    def take(self) -> list[tuple[str, bytes | None]]:
        taken = [(each.key, None if each.payload is None else bytes(each.payload)) for each in self.samples]
        self.samples.clear()
        return taken


class Asked:
    """A query's answers."""

    def __init__(self, querier: Querier, payload: bytes = b'?', timeout_s: float = 600.0) -> None:
        self.answers: list[object] = []
        self.ends = 0
        self.number = querier.ask(payload, b'att', self.answers.append, self._end, timeout_s)

    def _end(self) -> None:
        self.ends += 1

    @property
    def payloads(self) -> list[bytes]:
        return [bytes(each.payload or b'') for each in self.answers if isinstance(each, Sample | ReplyError)]


@pytest.fixture
def three() -> Iterator[tuple[Session, Session, Session, list[Cable]]]:
    """A session linked to two others, which are not linked to each other."""
    hub, one, other = Session(b'\xbb'), Session(b'\xa1'), Session(b'\xa2')
    yield hub, one, other, [Cable(hub, one).start(), Cable(hub, other).start()]
    assert not hub.failures + one.failures + other.failures


def carry(cables: list[Cable]) -> None:
    for _ in range(4):
        for cable in cables:
            cable.carry()


def test_a_put_goes_to_those_that_want_it_and_here(
    three: tuple[Session, Session, Session, list[Cable]],
) -> None:
    hub, one, other, cables = three
    here, plain, wild, else_where = Heard(), Heard(), Heard(), Heard()
    hub.declare_subscriber('a/b', here)
    one.declare_subscriber('a/b', plain)
    other.declare_subscriber('a/**', wild)
    other.declare_subscriber('c', else_where)
    carry(cables)
    Publication(hub, 'a/b').put(b'x')
    carry(cables)
    assert here.take() == plain.take() == wild.take() == [('a/b', b'x')]
    assert else_where.take() == []
    Publication(one, 'a/b').put(b'y')
    carry(cables)
    assert (here.take(), plain.take(), wild.take()) == ([('a/b', b'y')], [('a/b', b'y')], [])


def test_a_subscriber_that_wants_nothing_of_its_own_session() -> None:
    one, other, cable = pair()
    remote_only, all_of_it = Heard(), Heard()
    one.declare_subscriber('k', remote_only, takes_own=False)
    one.declare_subscriber('k', all_of_it)
    Publication(one, 'k').put(b'own')
    cable.carry()
    Publication(other, 'k').put(b'other')
    cable.carry()
    assert remote_only.take() == [('k', b'other')]
    assert all_of_it.take() == [('k', b'own'), ('k', b'other')]


def test_a_deletion_arrives_as_such() -> None:
    one, other, cable = pair()
    heard = Heard()
    other.declare_subscriber('k', heard)
    cable.carry()
    Publication(one, 'k').delete()
    cable.carry()
    assert heard.take() == [('k', None)]


def test_late_joiners_are_told_everything_and_leavers_nothing() -> None:
    one, other = Session(b'\xb1'), Session(b'\xa1')
    heard, tokens = Heard(), Heard()
    number = other.declare_subscriber('k', heard)
    other.declare_token('t/1')
    one.watch_tokens('t/*', tokens, history=True)
    cable = Cable(one, other).start()
    assert tokens.take() == [('t/1', b'')]
    Publication(one, 'k').put(b'1')
    cable.carry()
    assert heard.take() == [('k', b'1')]
    other.undeclare(number)
    cable.carry()
    Publication(one, 'k').put(b'2')
    assert cable.wires[0].take() == b''
    cable.cut()
    assert tokens.take() == [('t/1', None)]


def test_until_a_peer_has_told_all_it_gets_everything() -> None:
    one, other = Session(b'\xb1'), Session(b'\xa1')
    heard = Heard()
    other.declare_subscriber('k', heard)
    other.declare_queryable('q', lambda query: query.answer(query.key, b'yes'), complete=True)
    cable = Cable(one, other)
    link = cable.links[0]
    cable.start()
    link.peer.knows_all = False
    link.peer.subscribers.pop(1)
    link.peer.queryables.pop(2)
    one.routes.version += 1
    Publication(one, 'k').put(b'early')
    asked = Asked(Querier(one, 'q', target=Target.ALL_COMPLETE))
    cable.carry()
    assert heard.take() == [('k', b'early')]
    assert (asked.payloads, asked.ends) == ([b'yes'], 1)


def test_keys_travel_as_numbers_where_either_side_has_declared_one() -> None:
    one, other, cable = pair()
    heard = Heard()
    other.declare_subscriber('a/long/key/that/is/declared', heard)
    cable.carry()
    Publication(one, 'a/long/key/that/is/declared').put(b'x')
    assert b'long' not in cable.wires[0].data
    cable.carry()
    other.declare_subscriber('b/**', heard)
    cable.carry()
    publication = Publication(one, 'b/long')
    publication.put(b'y')
    assert b'b/long' in cable.wires[0].data  # declared once
    cable.carry()
    publication.put(b'z')
    assert b'long' not in cable.wires[0].data
    cable.carry()
    assert [payload for _, payload in heard.take()] == [b'x', b'y', b'z']


def test_numbers_of_keys_are_given_back_and_not_given_out_again_at_once() -> None:
    one, other, cable = pair()
    other.declare_subscriber('**', lambda _: None)
    cable.carry()
    for number in range(300):
        publication = Publication(one, f'k/{number}')
        publication.put(b'')
        publication.close()
    cable.carry()
    assert one.expressions.keys == {}
    assert cable.links[1].peer.expressions == {1: '**'} or cable.links[1].peer.expressions == {}
    one.expressions.use('next')
    assert list(one.expressions.keys) == [301]


def test_tokens_are_counted_over_all_links(three: tuple[Session, Session, Session, list[Cable]]) -> None:
    hub, one, other, cables = three
    heard = Heard()
    hub.watch_tokens('t/**', heard, history=False)
    first, second = one.declare_token('t/x'), other.declare_token('t/x')
    carry(cables)
    assert heard.take() == [('t/x', b'')]
    one.undeclare(first)
    carry(cables)
    assert heard.take() == []
    assert hub.tokens('t/**') == ['t/x']
    other.undeclare(second)
    carry(cables)
    assert heard.take() == [('t/x', None)]
    assert hub.tokens('**') == []


def test_own_tokens_are_shown_too() -> None:
    session = Session(b'\xb1')
    heard = Heard()
    session.declare_token('t/before')
    watcher = session.watch_tokens('t/*', heard, history=True)
    number = session.declare_token('t/after')
    session.undeclare(number)
    assert heard.take() == [('t/before', b''), ('t/after', b''), ('t/after', None)]
    session.undeclare(watcher)
    session.declare_token('t/third')
    assert heard.take() == []


@pytest.mark.parametrize(
    ('target', 'expected'),
    [
        (Target.ALL, [b'complete', b'partial', b'wild']),
        (Target.ALL_COMPLETE, [b'complete', b'wild']),
        (Target.BEST_MATCHING, [b'complete']),
    ],
)
def test_who_is_asked(
    target: int, expected: list[bytes], three: tuple[Session, Session, Session, list[Cable]]
) -> None:
    hub, one, other, cables = three

    def answer_with(text: bytes) -> object:
        return lambda query: query.answer('q/1', text)

    one.declare_queryable('q/1', answer_with(b'complete'), complete=True)  # type: ignore[arg-type]
    if target != Target.BEST_MATCHING:
        one.declare_queryable('other', answer_with(b'other'), complete=True)  # type: ignore[arg-type]
    other.declare_queryable('q/1', answer_with(b'partial'), complete=False)  # type: ignore[arg-type]
    hub.declare_queryable('q/*', answer_with(b'wild'), complete=target != Target.BEST_MATCHING)  # type: ignore[arg-type]
    carry(cables)
    asked = Asked(Querier(hub, 'q/1', target=target))
    carry(cables)
    assert (sorted(asked.payloads), asked.ends) == (expected, 1)


def test_a_query_that_nobody_answers_ends_at_once() -> None:
    one, _, _ = pair()
    assert Asked(Querier(one, 'nobody')).ends == 1


def test_several_queryables_of_one_session_answer_and_say_once_that_they_are_done() -> None:
    one, other, cable = pair()
    queries: list[Query] = []
    for _ in range(3):
        other.declare_queryable('q', queries.append, complete=True)
    cable.carry()
    asked = Asked(Querier(one, 'q', target=Target.ALL_COMPLETE))
    cable.carry()
    for at, query in enumerate(queries):
        assert asked.ends == 0
        query.answer('q', b'%d' % at)
        query.end()
        query.reply('q', b'too late')
        cable.carry()
    assert (asked.payloads, asked.ends) == ([b'0', b'1', b'2'], 1)
    assert one.queries.pending == {}


def test_large_replies_travel_in_pieces_and_end_behind_them() -> None:
    one, other, cable = pair()
    other.declare_queryable('q', lambda query: query.answer('q', bytes(300_000), b'a'), complete=True)
    cable.carry()
    asked = Asked(Querier(one, 'q'), payload=bytes(100_000))
    cable.carry()
    assert (list(map(len, asked.payloads)), asked.ends) == ([300_000], 1)


def test_a_reply_on_another_key_is_thrown_away_unless_it_was_asked_for() -> None:
    one, other, cable = pair()
    other.declare_queryable('q/**', lambda query: query.answer('else/where', b'x'), complete=True)
    cable.carry()
    asked, any_key = Asked(Querier(one, 'q/1')), Asked(Querier(one, 'q/1', parameters='_max=1;_anyke'))
    cable.carry()
    assert (asked.payloads, asked.ends) == ([], 1)
    assert (any_key.payloads, any_key.ends) == ([b'x'], 1)


def test_an_error_is_an_answer() -> None:
    one, other, cable = pair()

    def refuse(query: Query) -> None:
        query.reply_error(b'no')
        query.end()

    other.declare_queryable('q', refuse, complete=True)
    cable.carry()
    asked = Asked(Querier(one, 'q'))
    cable.carry()
    assert (asked.answers, asked.ends) == ([ReplyError(b'no')], 1)


def test_a_link_that_is_lost_has_had_its_last_word(
    three: tuple[Session, Session, Session, list[Cable]],
) -> None:
    hub, one, other, cables = three
    for session in (one, other):
        session.declare_queryable('q', lambda _: None, complete=True)
    carry(cables)
    asked = Asked(Querier(hub, 'q', target=Target.ALL))
    cables[0].cut()
    assert asked.ends == 0
    cables[1].cut()
    assert asked.ends == 1
    assert hub.queries.pending == {}


def test_a_query_to_a_link_that_was_lost_meanwhile_ends() -> None:
    one, other, cable = pair()
    other.declare_queryable('q', lambda _: None, complete=True)
    cable.carry()
    querier = Querier(one, 'q')
    Asked(querier)
    cable.links[0].close()  # as the reading thread does, before it tells the session
    assert Asked(querier).ends == 1


def test_a_query_whose_time_is_over_ends_with_an_error() -> None:
    one, other, cable = pair()
    held: list[Query] = []
    other.declare_queryable('q', held.append, complete=True)
    cable.carry()
    querier = Querier(one, 'q')
    long, short = Asked(querier, timeout_s=600), Asked(querier, timeout_s=1)
    assert one.queries.next_timeout == one.time.now + 1
    assert one.effects.sooner == 2
    cable.carry()
    one.queries.expire()
    assert short.ends == 0
    one.time.now += 1
    one.queries.expire()
    assert (short.answers, short.ends, long.ends) == ([TIMEOUT], 1, 0)
    held[1].answer('q', b'late')
    cable.carry()
    assert (short.answers, short.ends) == ([TIMEOUT], 1)
    assert one.queries.next_timeout == one.time.now + 599


def test_a_query_that_is_forgotten_calls_nobody() -> None:
    one, other, cable = pair()
    held: list[Query] = []
    other.declare_queryable('q', held.append, complete=True)
    one.declare_queryable('q', held.append, complete=True)
    cable.carry()
    asked = Asked(Querier(one, 'q', target=Target.ALL))
    cable.carry()
    one.queries.cancel(asked.number)
    one.queries.cancel(asked.number)
    for query in held:
        query.answer('q', b'late')
    cable.carry()
    assert (asked.answers, asked.ends) == ([], 0)
    assert one.queries.pending == {}


def test_consolidation() -> None:
    one, other, cable = pair()

    def answer(query: Query) -> None:
        for key, payload in [('q/a', b'1'), ('q/b', b'2'), ('q/a', b'3')]:
            other.time.now += 1
            query.reply(key, payload, None, other.stamp())
        query.end()

    other.declare_queryable('q/**', answer, complete=True)
    cable.carry()
    results = {}
    for consolidation in (Consolidation.NONE, Consolidation.MONOTONIC, Consolidation.LATEST):
        asked = Asked(Querier(one, 'q/*', consolidation=consolidation))
        cable.carry()
        results[consolidation] = asked.payloads
    assert results == {
        Consolidation.NONE: [b'1', b'2', b'3'],
        Consolidation.MONOTONIC: [b'1', b'2', b'3'],
        Consolidation.LATEST: [b'3', b'2'],
    }


def test_a_query_to_oneself_is_answered_on_the_spot_unless_only_others_are_asked() -> None:
    session = Session(b'\xb1')
    session.declare_queryable(
        'q', lambda query: query.answer('q', bytes(query.payload or b'')), complete=True
    )
    asked = Asked(Querier(session, 'q', target=Target.ALL_COMPLETE), payload=b'me')
    assert (asked.payloads, asked.ends) == ([b'me'], 1)
    others = Asked(Querier(session, 'q', target=Target.ALL_COMPLETE, asks_own=False))
    assert (others.payloads, others.ends) == ([], 1)


def test_a_client_is_told_what_it_asks_for_and_what_comes_later() -> None:
    client, peer, cable = pair(Role.CLIENT, Role.PEER)
    heard, tokens = Heard(), Heard()
    peer.declare_subscriber('k', heard)
    client.watch_tokens('t/*', tokens, history=True)
    cable.carry()
    peer.declare_token('t/1')
    cable.carry()
    Publication(client, 'k').put(b'x')
    cable.carry()
    assert heard.take() == [('k', b'x')]
    assert tokens.take() == [('t/1', b'')]
    back = Heard()
    client.declare_subscriber('b', back)
    cable.carry()
    Publication(peer, 'b').put(b'y')
    cable.carry()
    assert back.take() == [('b', b'y')]


def test_a_session_asks_no_router_for_its_own_tokens() -> None:
    session, router = Session(b'\xb1'), Session(b'\xaa', Role.ROUTER)
    session.interests.token_keys, session.interests.entity_keys = ['t/others/**'], ['k']
    cable = Cable(session, router).start()
    own = Heard()
    session.watch_tokens('t/b1/**', own, history=True, own_only=True)
    session.declare_token('t/b1/1')
    session.watch_tokens('t/a2/**', Heard(), history=True)
    assert own.take() == [('t/b1/1', b'')]
    sent = cable.wires[0].data
    assert b't/a2/**' in sent
    assert b't/b1/**' not in sent


def test_an_interest_in_the_present_of_one_key() -> None:
    client, peer, cable = pair(Role.CLIENT, Role.PEER)
    for link_interest in list(cable.links[1].peer.interests):
        cable.links[1].peer.interests.pop(link_interest)
    peer.declare_token('t/1')
    peer.declare_token('u/1')
    cable.links[0].outgoing.declare(interest(77, When.PRESENT, About.TOKENS, 't/**'))
    for piece in [cable.wires[0].take()]:
        cable.links[1].frames.receive(piece)
    assert b't/1' in cable.wires[1].data
    assert b'u/1' not in cable.wires[1].data
    assert cable.wires[1].data.endswith(b'\xbe\x4d\x21\x08\x1a')
    assert client.id == 'b2b1'


def test_a_router_is_told_of_us_and_asked_for_everything() -> None:
    peer, router = Session(b'\xb1'), Session(b'\xa1', Role.ROUTER)
    peer.gossip.locators = ('tcp/127.0.0.1:4242',)
    cable = Cable(peer, router)
    cable.links[0].start()
    for _ in range(2):
        cable.links[1].frames.receive(cable.wires[0].take())
        cable.links[0].frames.receive(cable.wires[1].take())
    said = cable.wires[0].data
    assert b'tcp/127.0.0.1:4242' in said
    assert b'\x0f\x21\x08' in said


def test_nodes_that_a_router_tells_of_are_met_by_the_greater_id() -> None:
    peer, router = Session(b'\xb1'), Session(b'\xa1', Role.ROUTER)
    cable = Cable(peer, router).start()
    lesser = Node(b'\xa2\xff', Role.PEER, ('tcp/h:1',), 1)
    greater = Node(b'\xb1\x01', Role.PEER, ('tcp/h:2',))
    for node in (lesser, greater, Node(b'\xb1', Role.PEER, ('tcp/h:3',)), Node(b'\xee', Role.CLIENT, ('x',))):
        cable.links[1].outgoing.declare(tell_of(node, 1))
    cable.carry()
    assert peer.to_meet == [lesser]
    assert set(peer.gossip.nodes) == {lesser.zid, greater.zid, b'\xee'}


@pytest.mark.parametrize(
    ('greater', 'lesser'), [('1ff', '2aa'), ('aa02', 'ff01'), ('10', '1000'), ('1001', '2000')]
)
def test_ids_are_compared_byte_by_byte_as_on_the_wire(greater: str, lesser: str) -> None:
    one, other = (bytes.fromhex(text.rjust(4, '0'))[::-1].rstrip(b'\0') for text in (greater, lesser))
    assert connects_to(one, Node(other, Role.PEER))
    assert not connects_to(other, Node(one, Role.PEER))


def test_captured_link_states_are_read() -> None:
    states = LinkStates()
    first = bytes.fromhex(
        'df0121081d01070002' + '04f91400a5' + '0201' + '0f' + b'tcp/127.0.0.1:1'.hex() + '0101'
    )
    assert states.read(Reader(first)) == [Node(bytes.fromhex('f91400a5'), Role.PEER, ('tcp/127.0.0.1:1',), 2)]
    again = bytes.fromhex('df0121080801040003' + '0101' + '78' + '0000')
    again = again[:4] + bytes((len(again) - 5,)) + again[5:]
    assert states.read(Reader(again))[0].zid == bytes.fromhex('f91400a5')


def test_two_links_that_cross_leave_one_and_both_sides_agree_which() -> None:
    one, other = Session(b'\xb1'), Session(b'\xa1')
    heard = Heard()
    one.watch_tokens('t/*', heard, history=True)
    other.declare_token('t/1')
    mine, theirs = Cable(one, other), Cable(other, one)
    mine.links[0].start()
    theirs.links[0].start()
    for cable in (mine, theirs):  # both handshakes get as far as the last message
        cable.links[1].frames.receive(cable.wires[0].take())
        cable.links[0].frames.receive(cable.wires[1].take())
    theirs.links[1].frames.receive(theirs.wires[0].take())
    mine.links[1].frames.receive(mine.wires[0].take())
    for _ in range(2):
        for cable in (theirs, mine):
            cable.carry()
    assert [link.handshake.connects for link in one.links] == [True]
    assert [link.handshake.connects for link in other.links] == [False]
    assert one.tokens('t/*') == ['t/1']


def test_stamps_only_grow() -> None:
    session = Session(b'\xb1')
    first, second = session.stamp(), session.stamp()
    session.time.now -= 5
    third = session.stamp()
    times = [Sample('k', b'', None, each).timestamp for each in (first, second, third)]
    assert all(each is not None for each in times)
    assert times == sorted(times)  # type: ignore[type-var]
    assert len(set(times)) == 3


def test_thousands_of_endpoints_are_seen_whole() -> None:
    one, other = Session(b'\xb1'), Session(b'\xa1')
    tokens = Heard()
    one.watch_tokens('t/**', tokens, history=True)
    for number in range(4000):
        other.declare_token(f't/{number}')
        other.declare_subscriber(f'k/{number}', lambda _: None)
    cable = Cable(one, other).start()
    assert len(tokens.take()) == 4000
    assert len(cable.links[0].peer.subscribers) == 4000
    cable.cut()
    assert len(tokens.take()) == 4000
