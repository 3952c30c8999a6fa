"""Every scenario between sessions of ours and of eclipse-zenoh, in both places and between two of ours."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator

import pytest
from helpers.isolation import free_port
from helpers.patience import PATIENCE, wait_for
from helpers.relay import relay
from helpers.zenoh_sides import Ours, Portable, Side, Theirs, address

from goalwire.zenoh.protocol.link_messages import Role

Open = Callable[..., Side]
PAIRS = [(Ours, Ours), (Ours, Theirs), (Theirs, Ours), (Portable, Portable)]
MAKES = pytest.mark.parametrize('makes', PAIRS, ids=lambda pair: f'{pair[0].make}-{pair[1].make}')


@pytest.fixture
def sides() -> Iterator[list[Side]]:
    """The sides, which are closed after the test, the last first."""
    opened: list[Side] = []
    yield opened
    for side in reversed(opened):
        side.close()
    assert not [each for each in threading.enumerate() if each.name.startswith('goalwire-zenoh')]


@pytest.fixture
def pair(makes: tuple[type[Side], type[Side]], sides: list[Side]) -> tuple[Side, Side]:
    """Two linked peers, the first of which listens."""
    where = address()
    one = makes[0]('peer', listen=(where,))  # type: ignore[call-arg]
    sides.append(one)
    other = makes[1]('peer', connect=(where,))  # type: ignore[call-arg]
    sides.append(other)
    wait_for(lambda: other.id in one.links() and one.id in other.links(), 'the link')
    return one, other


@MAKES
def test_messages_of_all_sizes_arrive_in_order_both_ways(pair: tuple[Side, Side]) -> None:
    for sender, receiver in (pair, pair[::-1]):
        heard = receiver.subscribe('a/*')
        ready = receiver.token(f'ready/{sender.id}')
        watch = sender.watch('ready/**')
        watch.wait(1)
        sizes = [0, 1, 127, 128, 16383, 16384, 49150, 65535, 65536, 1_000_000, 3]
        for size in sizes:
            sender.put('a/b', bytes(size))
        assert [(key, len(payload or b'')) for key, payload in heard.wait(len(sizes))] == [
            ('a/b', size) for size in sizes
        ]
        ready()


@pytest.mark.parametrize('ours_connects', [True, False])
@pytest.mark.parametrize('numbers', ['8bit', '16bit'])
def test_a_peer_with_smaller_sequence_numbers_is_served(
    numbers: str, ours_connects: bool, sides: list[Side]
) -> None:
    """Numbers of 8 bits are modulo 128: each way they go round, also within one message in pieces."""
    where = address()
    if ours_connects:
        sides.append(Theirs('peer', listen=(where,), numbers=numbers))
        sides.append(Ours('peer', connect=(where,)))
    else:
        sides.append(Ours('peer', listen=(where,)))
        sides.append(Theirs('peer', connect=(where,), numbers=numbers))
    for sender, receiver in (sides, sides[::-1]):
        heard = receiver.subscribe('a/b')
        ready = receiver.token(f'ready/{sender.id}')
        sender.watch(f'ready/{sender.id}').wait(1)
        sizes = [*range(300), 2_000_000, *range(300), 9_000_000, 5]
        for size in sizes:
            sender.put('a/b', bytes(size))
        assert [len(payload or b'') for _, payload in heard.wait(len(sizes))] == sizes
        ready()
        receiver.serve(f'q/{sender.id}', b'yes')
        wait_for(lambda: sender.ask(f'q/{sender.id}').wait() == [(f'q/{sender.id}', b'yes')], 'it')  # noqa: B023


@MAKES
def test_queries_replies_and_errors_both_ways(pair: tuple[Side, Side]) -> None:
    for number, (client, server) in enumerate((pair, pair[::-1])):
        server.serve(f'q/{number}', b'yes ')
        server.serve(f'e/{number}', None, error=b'no')
        wait_for(lambda: client.ask(f'e/{number}').wait(), 'the queryables')  # noqa: B023
        assert client.ask(f'q/{number}', b'?').wait() == [(f'q/{number}', b'yes ?')]
        assert client.ask(f'q/{number}', bytes(300_000)).wait() == [(f'q/{number}', b'yes ' + bytes(300_000))]
        assert client.ask(f'e/{number}').wait() == [('error', b'no')]
        assert client.ask('nobody').wait() == []


@MAKES
def test_many_queries_in_flight_are_all_answered(pair: tuple[Side, Side]) -> None:
    client, server = pair
    server.serve('q', b'')
    wait_for(lambda: client.ask('q').wait(), 'the queryable')
    asked = [client.ask('q', b'%d' % number) for number in range(500)]
    assert [each.wait() for each in asked] == [[('q', b'%d' % number)] for number in range(500)]


@MAKES
def test_a_query_that_is_not_answered_ends_with_its_time(pair: tuple[Side, Side]) -> None:
    client, server = pair
    server.serve('slow', None)
    watch = client.watch('up')
    server.token('up')
    watch.wait(1)
    assert client.ask('slow', timeout_s=0.2).wait() == [('error', b'Timeout')]


@MAKES
def test_a_query_ends_when_its_link_is_lost(pair: tuple[Side, Side]) -> None:
    client, server = pair
    server.serve('slow', None)
    watch = client.watch('up')
    server.token('up')
    watch.wait(1)
    asked = client.ask('slow', timeout_s=60)
    wait_for(lambda: server.held, 'the query')
    server.close()
    assert asked.wait() == []


@MAKES
def test_tokens_come_and_go_with_their_declaration_and_their_session(pair: tuple[Side, Side]) -> None:
    one, other = pair
    first = other.token('t/1')
    heard = one.watch('t/**')
    other.token('t/2')
    assert sorted(heard.wait(2)) == [('t/1', b''), ('t/2', b'')]
    first()
    assert heard.wait(3)[2:] == [('t/1', None)]
    other.close()
    assert heard.wait(4)[3:] == [('t/2', None)]


@MAKES
def test_a_full_link_loses_nothing_that_may_not_be_dropped(pair: tuple[Side, Side]) -> None:
    one, other = pair
    heard = other.subscribe('big')
    watch = one.watch('up')
    other.token('up')
    watch.wait(1)
    for _ in range(40):
        one.put('big', bytes(500_000))
    assert len(heard.wait(40)) == 40


@MAKES
def test_two_that_both_write_without_end_do_not_wait_for_each_other_for_ever(
    pair: tuple[Side, Side],
) -> None:
    heard = [side.subscribe('big/*') for side in pair]
    for side, other in (pair, pair[::-1]):
        watch = side.watch(f'up/{other.id}')
        other.token(f'up/{other.id}')
        watch.wait(1)

    def write(side: Side) -> None:
        for _ in range(30):
            side.put(f'big/{side.id}', bytes(1_000_000))

    writers = [threading.Thread(target=write, args=(side,)) for side in pair]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    for at, each in enumerate(heard):
        key = f'big/{pair[1 - at].id}'
        wait_for(lambda: len([1 for found, _ in each.samples if found == key]) == 30, key)  # noqa: B023


@MAKES
def test_wildcards_meet_wherever_they_stand(pair: tuple[Side, Side]) -> None:
    for number, (sender, receiver) in enumerate((pair, pair[::-1])):
        heard = receiver.subscribe(f'{number}/a/**/z'), receiver.subscribe(f'{number}/b/x$*')
        watch = sender.watch(f'{number}/*/up')
        receiver.token(f'{number}/now/up')
        assert watch.wait(1) == [(f'{number}/now/up', b'')]
        for key in ('a/z', 'a/z/b', 'a/b/c/z', 'b/yx', 'b/xyz', 'b/x', 'a/last/z', 'b/x/last', 'b/xlast'):
            sender.put(f'{number}/{key}', b'')
        assert [key[2:] for key, _ in heard[0].wait(3)] == ['a/z', 'a/b/c/z', 'a/last/z']
        assert [key[2:] for key, _ in heard[1].wait(3)] == ['b/xyz', 'b/x', 'b/xlast']


@MAKES
def test_a_liveliness_query_tells_what_there_is_now(pair: tuple[Side, Side]) -> None:
    for number, (asking, other) in enumerate((pair, pair[::-1])):
        first = other.token(f'{number}/t/1')
        other.token(f'{number}/t/2')
        other.token(f'{number}/u/3')
        both, one = {f'{number}/t/1', f'{number}/t/2'}, {f'{number}/t/2'}
        wait_for(lambda: asking.present(f'{number}/t/*') == both, 'both')  # noqa: B023
        first()
        wait_for(lambda: asking.present(f'{number}/t/*') == one, 'the other')  # noqa: B023
        assert asking.present(f'{number}/nobody') == set()


@MAKES
def test_answers_on_one_key_are_consolidated_where_that_is_asked_for(pair: tuple[Side, Side]) -> None:
    for number, (client, server) in enumerate((pair, pair[::-1])):
        key = f'q/{number}'
        server.serve(key, b'1')
        server.serve(key, b'2')
        wait_for(lambda: len(client.ask(key).wait()) == 2, 'both queryables')  # noqa: B023
        assert sorted(client.ask(key).wait()) == [(key, b'1'), (key, b'2')]
        assert client.ask(key, latest=True).wait() in ([(key, b'1')], [(key, b'2')])


@MAKES
def test_a_late_joiner_is_told_by_every_link_and_reaches_all(
    makes: tuple[type[Side], type[Side]], sides: list[Side]
) -> None:
    where = address(), address()
    one = makes[0]('peer', listen=(where[0],))  # type: ignore[call-arg]
    other = makes[1]('peer', listen=(where[1],), connect=(where[0],))  # type: ignore[call-arg]
    sides += [one, other]
    for name, side in (('one', one), ('other', other)):
        side.serve(f'q/{name}', b'')
        side.token(f't/{name}')
    heard = one.subscribe('k/*'), other.subscribe('k/*')
    late = makes[1]('peer', connect=where)  # type: ignore[call-arg]
    sides.append(late)
    wait_for(lambda: late.present('t/*') == {'t/one', 't/other'}, 'the tokens of both')
    wait_for(lambda: one.id in late.links() and other.id in late.links(), 'both links')
    for name in ('one', 'other'):
        wait_for(lambda: late.ask(f'q/{name}', b'?').wait() == [(f'q/{name}', b'?')], 'it')  # noqa: B023
    for number in range(3):
        late.put(f'k/{number}', b'')
    for each in heard:  # each once: nobody passes on what it hears
        assert each.wait(3) == [('k/0', b''), ('k/1', b''), ('k/2', b'')]


@MAKES
def test_a_link_that_was_cut_comes_back_and_everything_is_declared_anew(
    makes: tuple[type[Side], type[Side]], sides: list[Side]
) -> None:
    ports = free_port(), free_port()
    with relay(*ports) as between:
        one = makes[0]('peer', listen=(f'tcp/127.0.0.1:{ports[1]}',))  # type: ignore[call-arg]
        sides.append(one)
        other = makes[1]('peer', connect=(f'tcp/127.0.0.1:{ports[0]}',))  # type: ignore[call-arg]
        sides.append(other)
        one.serve('q', b'')
        messages, seen = one.subscribe('k'), other.watch('t/*')
        former = one.token('t/1')
        one.token('t/2')
        assert sorted(seen.wait(2)) == [('t/1', b''), ('t/2', b'')]
        between.cut()
        assert sorted(seen.wait(4)[2:]) == [('t/1', None), ('t/2', None)]
        former()
        one.token('t/3')
        between.mend()
        assert sorted(seen.wait(6)[4:]) == [('t/2', b''), ('t/3', b'')]
        wait_for(lambda: other.ask('q', b'x').wait() == [('q', b'x')], 'an answer')
        other.put('k', b'y')
        assert messages.wait(1) == [('k', b'y')]
        for side in sides:
            side.close()
        sides.clear()


@MAKES
def test_a_session_that_comes_back_is_met_again(
    makes: tuple[type[Side], type[Side]], sides: list[Side]
) -> None:
    where = address()
    one = makes[0]('peer', listen=(where,))  # type: ignore[call-arg]
    other = makes[1]('peer', connect=(where,))  # type: ignore[call-arg]
    sides.append(other)
    heard = other.watch('t/*')
    message = other.subscribe('m')
    one.token('t/1')
    heard.wait(1)
    one.close()
    heard.wait(2)
    again = makes[0]('peer', listen=(where,))  # type: ignore[call-arg]
    sides.append(again)
    again.token('t/2')
    assert heard.wait(3) == [('t/1', b''), ('t/1', None), ('t/2', b'')]
    again.put('m', b'x')
    assert message.wait(1) == [('m', b'x')]


@MAKES
def test_peers_meet_through_a_router_and_talk_without_it(
    makes: tuple[type[Side], type[Side]], sides: list[Side]
) -> None:
    where = address()
    router = Theirs('router', listen=(where,))
    sides.append(router)
    for zids in (('10', '20'), ('21', '11')):  # either one is the one to connect
        pair = [
            make('peer', listen=('tcp/127.0.0.1:0',), connect=(where,), zid=zid)  # type: ignore[call-arg]
            for make, zid in zip(makes, zids, strict=True)
        ]
        sides += pair
        one, other = pair
        wait_for(lambda: other.id in one.links() and one.id in other.links(), 'each other')  # noqa: B023
    sides.remove(router)
    router.close()
    wait_for(lambda: router.id not in one.links() | other.links(), "the router's end")
    heard = other.subscribe('a')
    watch = one.watch('up')
    other.token('up')
    watch.wait(1)
    one.put('a', b'x')
    assert heard.wait(1) == [('a', b'x')]
    back = Theirs('router', listen=(where,))
    sides.append(back)
    wait_for(lambda: back.id in one.links() and back.id in other.links(), 'the router again')


@pytest.mark.parametrize('zid', ['10', 'ff'])
def test_a_peer_that_always_connects_is_linked_once(zid: str, sides: list[Side]) -> None:
    where = address()
    sides.append(Theirs('router', listen=(where,)))
    one = Ours('peer', listen=('tcp/127.0.0.1:0',), connect=(where,), zid='42')
    sides.append(one)
    one.token('t/1')
    other = Theirs('peer', listen=('tcp/127.0.0.1:0',), connect=(where,), zid=zid, strategy='always')
    sides.append(other)
    heard = other.watch('t/*')
    heard.wait(1)
    one.token('t/2')
    assert heard.wait(2) == [('t/1', b''), ('t/2', b'')]
    assert len([link for link in one.protocol.links if link.role is Role.PEER]) == 1


@MAKES
def test_a_client_behind_a_router(makes: tuple[type[Side], type[Side]], sides: list[Side]) -> None:
    where = address()
    sides.append(Theirs('router', listen=(where,)))
    client = makes[0]('client', connect=(where,))  # type: ignore[call-arg]
    peer = makes[1]('peer', connect=(where,))  # type: ignore[call-arg]
    sides += [client, peer]
    at_peer, at_client = peer.subscribe('to/peer'), client.subscribe('to/client')
    peer.serve('peer/q', b'p')
    client.serve('client/q', b'c')
    peer_sees, client_sees = peer.watch('t/*'), client.watch('t/*')
    client.token('t/client')
    peer.token('t/peer')
    peer_sees.wait(2)
    client_sees.wait(2)
    wait_for(lambda: peer.ask('client/q').wait() == [('client/q', b'c')], 'the client')
    wait_for(lambda: client.ask('peer/q').wait() == [('peer/q', b'p')], 'the peer')
    client.put('to/peer', b'1')
    peer.put('to/client', b'2')
    assert at_peer.wait(1) == [('to/peer', b'1')]
    assert at_client.wait(1) == [('to/client', b'2')]


@pytest.mark.parametrize('make', [Ours, Portable])
def test_a_client_of_a_session_of_ours(make: type[Ours], sides: list[Side]) -> None:
    where = address()
    peer = make('peer', listen=(where,))
    client = Theirs('client', connect=(where,))
    sides += [peer, client]
    heard, back = peer.subscribe('a'), client.subscribe('b')
    peer.serve('q', b'yes')
    tokens = client.watch('t/*')
    peer.token('t/1')
    tokens.wait(1)
    client.put('a', b'x')
    assert heard.wait(1) == [('a', b'x')]
    wait_for(lambda: client.ask('q').wait() == [('q', b'yes')], 'the answer')
    wait_for(lambda: (peer.put('b', b'y'), back.samples)[1], 'a message')  # type: ignore[func-returns-value]


@MAKES
def test_silent_links_live_as_long_as_they_say_so(
    makes: tuple[type[Side], type[Side]], sides: list[Side]
) -> None:
    where = address()
    one = makes[0]('peer', listen=(where,), lease_ms=400)  # type: ignore[call-arg]
    other = makes[1]('peer', connect=(where,), lease_ms=400)  # type: ignore[call-arg]
    sides += [one, other]
    heard = one.watch('t')
    other.token('t')
    heard.wait(1)
    threading.Event().wait(1.5)  # several leases in which nobody has anything to say
    assert heard.samples == [('t', b'')]


def test_thousands_of_endpoints_see_each_other_whole(sides: list[Side]) -> None:
    where = address()
    one, other = Ours('peer', listen=(where,)), Ours('peer')
    sides += [one, other]
    for number in range(2000):
        for side in (one, other):
            side.protocol.declare_token(f't/{side.id}/{number}')
            side.protocol.declare_subscriber(f'k/{side.id}/{number}', lambda _: None)
    heard = [one.watch(f't/{other.id}/*'), other.watch(f't/{one.id}/*')]
    third = Ours('peer', connect=(where,))
    sides.append(third)
    assert len(third.protocol.tokens('t/**')) == 2000
    assert heard[0].samples == []


@pytest.mark.parametrize('make', [Theirs, Ours], ids=lambda make: make.make)
def test_a_session_offers_what_is_known_and_nothing_else(make: type[Side], sides: list[Side]) -> None:
    """A release of eclipse-zenoh with another version, patch or extension is to be looked at first."""
    offered: list[bytes] = []

    def listen() -> None:
        connection, _ = listener.accept()
        with connection:
            connection.settimeout(PATIENCE)
            size = int.from_bytes(connection.recv(2, socket.MSG_WAITALL), 'little')
            offered.append(connection.recv(size, socket.MSG_WAITALL))

    with socket.create_server(('127.0.0.1', 0)) as listener:
        listener.settimeout(PATIENCE)
        thread = threading.Thread(target=listen)
        thread.start()
        where = f'tcp/127.0.0.1:{listener.getsockname()[1]}'
        sides.append(make('peer', listen=(address(),), connect=(where,), zid='b4b3b2b1'))  # type: ignore[call-arg]
        thread.join()
    (init,) = offered
    batch_size = init[8:10]
    assert init.hex() == f'c10931b1b2b3b40a{batch_size.hex()}812701'
