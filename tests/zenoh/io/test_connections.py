"""Accidents of a connection: strangers, silence, floods, deaths; and what stays behind."""

from __future__ import annotations

import gc
import os
import socket
import struct
import threading
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from time import monotonic

import pytest
from helpers import zenoh_sides
from helpers.patience import PATIENCE, wait_for
from helpers.zenoh_captured import conversation
from helpers.zenoh_sides import Ours, address

from goalwire.concurrency import poller
from goalwire.concurrency.poller import IN, Poller
from goalwire.errors import TransportError
from goalwire.zenoh.io import backpressure, dialler, dials, fault_log, native_session, socket_link
from goalwire.zenoh.io.dialler import DialSlots, Retry
from goalwire.zenoh.io.endpoints import Endpoint, is_quickly_resolved, parse, resolve
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.channels import fragment_head
from goalwire.zenoh.protocol.link_messages import Role, close_message
from goalwire.zenoh.protocol.link_state import Node
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT
from goalwire.zenoh.protocol.primitives import EXPIRED, GENERIC, encode_z

A_SAYS = [batch for batch in conversation() if batch.sender == 'A']
B_SAYS = [batch for batch in conversation() if batch.sender == 'B']


@pytest.fixture
def warnings(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The warnings of sessions."""
    told: list[str] = []
    monkeypatch.setattr(fault_log.FaultLog, 'warn', lambda _, text: told.append(text))
    return told


@pytest.fixture
def listener(warnings: list[str]) -> Iterator[Ours]:
    side = Ours('peer', listen=(address(),))
    yield side
    side.close()


class Stranger:
    """A bare connection to a session."""

    def __init__(self, other: Ours | socket.socket) -> None:
        """`other` is a session to connect to, or the socket of one that has connected."""
        if isinstance(other, Ours):
            where = parse(other.protocol.gossip.locators[0])
            self.socket = socket.create_connection((where.host, where.port), timeout=PATIENCE)
        else:
            self.socket = other
            self.socket.settimeout(PATIENCE)

    def says(self, data: bytes) -> None:
        self.socket.sendall(len(data).to_bytes(2, 'little') + data)

    def hears(self) -> bytes:
        size = int.from_bytes(self.socket.recv(2, socket.MSG_WAITALL), 'little')
        return self.socket.recv(size, socket.MSG_WAITALL) if size else b''

    def shake_hands(self, opening: bytes | None = None) -> None:
        self.says(B_SAYS[0].data)
        cookie = self.hears()[-19:-3]
        self.says(opening or b'\x42\x3c\x05\x10' + cookie)
        assert self.hears()[0] & 0x1F == 2

    def is_hung_up(self) -> bool:
        with suppress(ConnectionResetError):
            while self.socket.recv(65536):
                pass
        self.socket.close()
        return True


def test_a_malformed_frame_closes_its_link_with_one_line_and_no_other(
    listener: Ours, warnings: list[str]
) -> None:
    good, bad = Ours('peer', connect=(listener.protocol.gossip.locators[0],)), Stranger(listener)
    bad.shake_hands()
    wait_for(lambda: len(listener.protocol.links) == 2, 'both links')
    bad.says(b'\x25\x05\x3d\x00\x7f')
    assert bad.is_hung_up()
    wait_for(lambda: len(listener.protocol.links) == 1, 'the end')
    assert len(warnings) == 1
    assert 'session b4b3b2b1 was closed: a PUT or DEL' in warnings[0] or 'cut off' in warnings[0]
    heard = listener.subscribe('a')
    wait_for(lambda: (good.put('a', b'x'), heard.samples)[1], 'the other link')  # type: ignore[func-returns-value]
    good.close()


@pytest.mark.parametrize('first', [b'', b'\x19', B_SAYS[0].sent, B_SAYS[0].sent[:7]])
def test_a_connection_that_says_too_little_is_closed(
    first: bytes, monkeypatch: pytest.MonkeyPatch, warnings: list[str]
) -> None:
    monkeypatch.setattr(bounds, 'HANDSHAKE_S', 0.2)
    side = Ours('peer', listen=(address(),))
    stranger = Stranger(side)
    stranger.socket.sendall(first)
    assert stranger.is_hung_up()
    wait_for(lambda: [each for each in warnings if 'took too long' in each], 'a warning')
    side.close()


def test_something_else_than_zenoh_is_hung_up_on(listener: Ours, warnings: list[str]) -> None:
    stranger = Stranger(listener)
    stranger.socket.sendall(b'GET / HTTP/1.1\r\nHost: robot\r\n\r\n' * 2000)
    assert stranger.is_hung_up()
    wait_for(lambda: warnings, 'a warning')
    assert listener.protocol.links == ()


def test_a_link_that_dies_in_the_midst_of_a_message_leaves_nothing(listener: Ours) -> None:
    heard = listener.subscribe('**')
    stranger = Stranger(listener)
    stranger.shake_hands()
    piece = bytes(40_000)
    stranger.says(b'\xe6\x05\x02\x3d\x00\x01a\x01\x80\x80\x08' + piece)
    stranger.says(b'\x66\x06' + piece)
    stranger.socket.close()
    wait_for(lambda: not listener.protocol.links, 'the end')
    assert heard.samples == []


def test_a_silent_link_is_given_up_after_its_lease(listener: Ours) -> None:
    tokens = listener.watch('t')
    stranger = Stranger(listener)
    stranger.says(B_SAYS[0].data)
    cookie = stranger.hears()[-19:-3]
    stranger.says(b'\x02\xac\x02\x05\x10' + cookie)  # a lease of 300 ms
    assert stranger.hears()[0] & 0x1F == 2
    stranger.says(b'\xa5\x05\x31\x00\x9e\x21\x08\x26\x01\x00\x01t')
    tokens.wait(1)
    began = monotonic()
    assert stranger.is_hung_up()
    assert tokens.wait(2)[1] == ('t', None)
    assert monotonic() - began < 5


def test_one_that_does_not_read_stops_its_sender_until_the_link_is_given_up(
    listener: Ours, warnings: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(backpressure, 'ROOM_S', 0.3)
    stranger = Stranger(listener)
    stranger.shake_hands()
    wait_for(lambda: listener.protocol.links, 'the link')
    link = listener.protocol.links[0]
    most = 0
    for _ in range(100):
        listener.put('a', bytes(QUEUE_LIMIT // 2))  # not final yet, so it gets everything
        most = max(most, link.outgoing.queue.size)
        if not link.outgoing.is_open:
            break
    wait_for(lambda: not listener.protocol.links, 'the end')
    assert most < 2 * QUEUE_LIMIT
    assert 'nothing was taken' in warnings[0]
    stranger.socket.close()


def test_one_that_does_not_read_makes_others_lose_nothing(listener: Ours) -> None:
    stranger = Stranger(listener)
    stranger.shake_hands()
    wait_for(lambda: listener.protocol.links, 'the link')
    good = Ours('peer', connect=(listener.protocol.gossip.locators[0],))
    heard = good.subscribe('a')
    watch = listener.watch('up')
    good.token('up')
    watch.wait(1)
    for _ in range(100):
        listener.put('a', bytes(100_000), droppable=True)
        if len(heard.samples) < 3:
            wait_for(lambda: heard.samples, 'the first')
    wait_for(lambda: len(heard.samples) == 100 or listener.session.statistics()['dropped'], 'the rest')
    assert listener.session.statistics()['dropped'] > 0
    stranger.socket.close()
    good.close()


def test_a_reader_that_is_interrupted_by_a_signal_loses_no_byte(listener: Ours) -> None:
    """An exception of a signal's handler, in the midst of a batch, loses that batch alone."""
    other = Ours('peer', connect=(listener.protocol.gossip.locators[0],))
    heard = listener.subscribe('a')
    watch = other.watch('up')
    listener.token('up')
    watch.wait(1)
    real = listener.protocol.routes.receivers
    raised: list[bool] = []

    def raise_once(*arguments: object) -> object:
        if not raised:
            raised.append(True)
            raise KeyboardInterrupt
        return real(*arguments)  # type: ignore[arg-type]

    listener.protocol.routes.receivers = raise_once  # type: ignore[method-assign, assignment]
    link = listener.protocol.links[0]
    with pytest.raises(KeyboardInterrupt):
        _lead_until_interrupted(listener, lambda: other.put('a', b'lost'))
    other.put('a', b'kept')
    assert heard.wait(1) == [('a', b'kept')]
    assert listener.protocol.links == (link,)
    other.close()


def _lead_until_interrupted(side: Ours, then: Callable[[], None]) -> None:
    """Read the wire in this thread; another thread calls `then` once this one reads."""
    poller, reader = side.session.wire_poller, threading.get_ident()

    def go_on() -> None:
        wait_for(lambda: poller._leader and poller._leaders_thread == reader, 'this thread to read')
        then()

    thread = threading.Thread(target=go_on)
    thread.start()
    try:
        side.session.wait_until(lambda: False, PATIENCE)
    finally:
        thread.join()


def descriptors() -> int:
    return len(os.listdir('/proc/self/fd'))  # noqa: PTH208


def dies(stranger: Stranger) -> None:
    """Linger for 0 s: what was on its way is thrown away, as where a machine loses its power."""
    stranger.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
    stranger.socket.close()


def open_and_die(stranger: Stranger) -> None:
    stranger.shake_hands()
    stranger.says(b'\xa5\x05\x31\x00\x9e\x21\x08\x26\x01\x00\x01t')
    dies(stranger)


def open_and_close(stranger: Stranger) -> None:
    stranger.shake_hands()
    stranger.says(b'\xa5\x05\x31\x00\x9e\x21\x08\x26\x01\x00\x01t')
    stranger.says(close_message(GENERIC))
    assert stranger.is_hung_up()


def die_in_mid_fragment(stranger: Stranger) -> None:
    stranger.shake_hands()
    stranger.says(b'\xe6\x05\x02\x3d\x00\x01a\x01\x80\x80\x08' + bytes(2000))
    dies(stranger)


def die_in_the_handshake(stranger: Stranger) -> None:
    stranger.says(B_SAYS[0].data)
    assert stranger.hears()[0] & 0x1F == 1
    dies(stranger)


def end_within_a_message_of_the_handshake(stranger: Stranger) -> None:
    stranger.socket.sendall(B_SAYS[0].sent[:9])
    stranger.socket.shutdown(socket.SHUT_WR)
    assert stranger.is_hung_up()


def be_refused(stranger: Stranger) -> None:
    stranger.says(B_SAYS[0].data.replace(b'\x09', b'\x08', 1))
    assert stranger.is_hung_up()


@pytest.mark.skipif(not os.path.isdir('/proc/self/fd'), reason='there is no /proc')  # noqa: PTH112
@pytest.mark.parametrize(
    'behave',
    [
        open_and_die,
        open_and_close,
        die_in_mid_fragment,
        die_in_the_handshake,
        end_within_a_message_of_the_handshake,
        be_refused,
    ],
    ids=lambda behave: behave.__name__,
)
def test_many_links_leave_nothing_behind(listener: Ours, behave: Callable[[Stranger], None]) -> None:
    """A thousand of them, between programs: `python -m benchmarks.endurance links`."""

    def open_and_lose(count: int) -> None:
        for _ in range(count):
            behave(Stranger(listener))
            wait_for(lambda: not listener.session._links, 'the end')

    expect_nothing_left(open_and_lose)
    assert listener.protocol.tokens('**') == []


@pytest.mark.skipif(not os.path.isdir('/proc/self/fd'), reason='there is no /proc')  # noqa: PTH112
def test_links_that_were_dialled_and_lost_leave_nothing_behind(
    warnings: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(zenoh_sides, 'Retry', lambda *_: Retry(0.001, 0.001))
    with socket.create_server(('127.0.0.1', 0)) as stranger:
        stranger.settimeout(PATIENCE)

        def take_and_lose(count: int) -> None:
            for _ in range(count):
                taken = Stranger(stranger.accept()[0])
                assert taken.hears()[0] & 0x1F == 1
                taken.says(A_SAYS[0].data)
                assert taken.hears()[0] & 0x1F == 2
                taken.says(A_SAYS[1].data)
                assert taken.hears()[0] & 0x1F == 5
                dies(taken)

        monkeypatch.setattr(native_session, 'CONNECTING_S', 0.0)
        side = Ours('peer', connect=(f'tcp/127.0.0.1:{stranger.getsockname()[1]}',))
        try:
            expect_nothing_left(take_and_lose)
        finally:
            side.close()


def expect_nothing_left(open_and_lose: Callable[[int], None]) -> None:
    """Have links opened and lost; what they leave must be gone."""
    open_and_lose(20)
    gc.collect()
    threads, files = threading.active_count(), descriptors()
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    open_and_lose(80)
    gc.collect()
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # A link leaves the tables first, its socket and its thread a moment later.
    # One that dials again has a socket now, and may have had none then; of 80 links 80 would be left.
    wait_for(
        lambda: threading.active_count() <= threads and descriptors() <= files + 2, 'what was there before'
    )
    # A link that has dialled again may be reading at this moment, into room that it gives back.
    assert after - before < 60_000 + socket_link.READ_SIZE


def test_who_waits_for_room_on_a_link_that_dies_goes_on(listener: Ours, warnings: list[str]) -> None:
    stranger = Stranger(listener)
    stranger.shake_hands()
    wait_for(lambda: listener.protocol.links, 'the link')
    (link,) = listener.protocol.links
    waiting = listener.session._links[link].waiting

    def write() -> None:
        for _ in range(20):
            listener.put('a', bytes(QUEUE_LIMIT))

    writer = threading.Thread(target=write)
    writer.start()
    wait_for(lambda: waiting, 'a writer that waits')
    dies(stranger)
    writer.join(PATIENCE)
    assert not writer.is_alive()
    wait_for(lambda: not listener.session._links, 'the end')
    assert (link.outgoing.queue.size, warnings) == (0, [])


def test_one_that_says_a_byte_now_and_then_has_no_more_time_than_others(
    monkeypatch: pytest.MonkeyPatch, warnings: list[str]
) -> None:
    monkeypatch.setattr(bounds, 'HANDSHAKE_S', 0.3)
    side = Ours('peer', listen=(address(),))
    stranger = Stranger(side)
    with suppress(ConnectionError):
        for byte in b'\xff\xff' + bytes(5000):
            stranger.socket.sendall(bytes((byte,)))
            threading.Event().wait(0.02)
    assert stranger.is_hung_up()
    wait_for(lambda: [each for each in warnings if 'took too long' in each], 'a warning')
    side.close()


def test_addresses() -> None:
    assert parse('tcp/localhost:7447') == ('tcp', 'localhost', 7447)
    assert parse('tcp/[::1]:7447?prio=1#iface=lo') == ('tcp', '::1', 7447)
    for text in ('', 'tcp', 'tcp/x', 'tcp/:1', 'tcp/h:70000', f'tcp/h:{"9" * 5000}', 'quic/h:1', 'udp/h:1'):
        with pytest.raises(TransportError):
            parse(text)


@pytest.mark.parametrize('host', ['a\0b', 'x' * 64 + '.local', '\udcff', ''])
def test_a_name_that_no_host_can_have_is_not_found(host: str) -> None:
    assert not is_quickly_resolved(host)
    with pytest.raises(OSError, match=r'\S'):
        resolve(Endpoint('tcp', host, 1))


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason='IPv6')
def test_every_address_takes_ipv4_too() -> None:
    with closing(Ours('peer', listen=('tcp/[::]:0',))) as listener:
        port = int(listener.protocol.gossip.locators[0].rpartition(':')[2])
        for host in ('127.0.0.1', '::1'):
            socket.create_connection((host, port), PATIENCE).close()


def test_a_port_that_is_taken_is_said(listener: Ours) -> None:
    where = listener.protocol.gossip.locators[0]
    with pytest.raises(TransportError, match=f"cannot listen on '{where}'"):
        Ours('peer', listen=(where,))


def test_a_client_without_router_does_not_open() -> None:
    with pytest.raises(TransportError, match='no router answers'):
        Ours('client', connect=(address(),))


@pytest.mark.parametrize('portable', [False, True])
def test_a_poller_waits_for_descriptors_timers_and_calls(portable: bool) -> None:
    poller = Poller('test', portable=portable)
    done: list[str] = []
    one, other = socket.socketpair()
    poller.register(one.fileno(), IN, lambda _: done.append(one.recv(9).decode()))
    poller.serve(poller.wait(1000))
    assert poller.wait(1000) == 0
    other.send(b'data')
    assert poller.wait(10**9) == 1
    poller.serve()
    poller.call(lambda: done.append('call'))
    poller.serve(poller.wait(10**9))
    later, cancelled = (
        poller.call_later(0.02, lambda: done.append('timer')),
        poller.call_later(0.01, done.clear),
    )
    cancelled.cancel()
    began = monotonic()
    while 'timer' not in done:
        poller.serve(poller.wait(10**10))
    assert monotonic() >= later.when
    assert monotonic() - began < 5
    assert done == ['data', 'call', 'timer']
    poller.close()
    assert poller.wait(0) == -1
    one.close()
    other.close()


def test_the_first_query_after_a_long_stop_goes_over_a_new_link() -> None:
    """The server has closed the link when the lease was over; the client reads that after it has asked."""
    with closing(Ours('peer', listen=(address(),))) as server:
        server.serve('k', b'yes')
        with closing(Ours('peer', connect=(server.protocol.gossip.locators[0],))) as client:
            wait_for(lambda: client.ask('k').wait() == [('k', b'yes')], 'the first answer')
            stopped, goes_on = threading.Event(), threading.Event()

            def stop() -> None:
                stopped.set()
                goes_on.wait(PATIENCE)

            client.session._poller.call(stop)
            assert stopped.wait(PATIENCE)
            (link,) = server.protocol.links
            server.session.close_link(link, 'nothing was heard for its lease', EXPIRED)
            wait_for(lambda: not server.protocol.links, 'the end of the link')
            client.protocol.stale_after = monotonic() - 1
            when_stale = client.protocol.relink

            def go_on() -> None:
                goes_on.set()
                when_stale()

            client.protocol.relink = go_on
            assert client.ask('k').wait() == [('k', b'yes')]


@pytest.fixture
def failures(monkeypatch: pytest.MonkeyPatch) -> list[Exception]:
    """The exceptions that handlers of the poller have raised."""
    raised: list[Exception] = []
    monkeypatch.setattr(poller, 'report_failure', lambda _, error: raised.append(error))
    return raised


def test_a_session_that_is_closed_while_a_handshake_ends_raises_nothing(
    listener: Ours, failures: list[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thread that waits for the link wakes up and closes the session before the link has told it all."""
    side = Ours('peer', listen=(address(),))
    session = side.session
    closer = threading.Thread(target=side.close)

    def wake_all() -> None:
        if session.protocol.links and not closer.ident:
            closer.start()
            wait_for(lambda: not session._links, 'the end of the links')

    monkeypatch.setattr(session, 'note_change', wake_all)
    other = Ours('peer', connect=(session.protocol.gossip.locators[0],))
    wait_for(lambda: closer.ident, 'the link')
    closer.join(PATIENCE)
    other.close()
    assert failures == []


def test_a_connection_that_is_ended_before_it_begins_waits_for_no_descriptor(
    listener: Ours, failures: list[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    start = socket_link.SocketLink.start
    started = threading.Event()

    def late(link: socket_link.SocketLink) -> None:
        link.end('the session is closed')
        start(link)
        started.set()

    monkeypatch.setattr(socket_link.SocketLink, 'start', late)
    stranger = Stranger(listener)
    assert started.wait(PATIENCE)
    assert stranger.is_hung_up()
    assert failures == []
    assert listener.session._links == {}


def test_a_dial_that_is_closed_while_it_connects_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    waits = Poller('it')
    with socket.create_server(('127.0.0.1', 0)) as server:
        where = f'tcp/127.0.0.1:{server.getsockname()[1]}'
        dial = dialler.Dial(
            (where,), waits, Retry(), when_connected=lambda *_: None, when_failed=lambda _: None
        )
        closer = threading.Thread(target=dial.close)
        call_later = waits.call_later

        def close_meanwhile(delay_s: float, function: Callable[[], None]) -> poller.Timer:
            closer.start()
            closer.join(0.1)  # it waits for the dial, or else has closed the socket by now
            return call_later(delay_s, function)

        monkeypatch.setattr(waits, 'call_later', close_meanwhile)
        dial.start()
        closer.join(PATIENCE)
        assert dial._socket is None
        assert len(waits._handlers) == 1
    waits.close()


def test_bad_links_are_told_of_at_powers_of_ten(listener: Ours, warnings: list[str]) -> None:
    for _ in range(25):
        stranger = Stranger(listener)
        stranger.says(b'\x7f%d' % (_ % 7))
        assert stranger.is_hung_up()
    wait_for(lambda: not listener.session._links, 'the ends')
    assert len(warnings) == 2
    assert '10 links by now' in warnings[1]


def test_a_newcomer_takes_the_place_of_the_oldest_that_says_nothing(
    listener: Ours, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'MOST_GREETINGS', 5)
    silent = [Stranger(listener) for _ in range(12)]
    other = Ours('peer', connect=(listener.protocol.gossip.locators[0],))
    wait_for(lambda: listener.links() == {other.id}, 'the newcomer')
    for each in silent[:7]:
        assert each.is_hung_up()
    assert listener.session.rejects.counts() == {'connection': 8}
    other.close()
    for each in silent[7:]:
        each.socket.close()


class SlowRouter:
    """Passes connections on to a session, each only after a pause, as a router does that a fleet dials."""

    def __init__(self, behind: Ours, pause_s: float) -> None:
        where = parse(behind.protocol.gossip.locators[0])
        self._behind = (where.host, where.port)
        self._pause_s = pause_s
        self._server = socket.create_server(('127.0.0.1', 0))
        self.address = f'tcp/127.0.0.1:{self._server.getsockname()[1]}'
        self.connections = 0
        self._open: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                here, _ = self._server.accept()
                self.connections += 1
                self._open.append(here)
                threading.Thread(target=self._carry_late, args=(here,), daemon=True).start()

    def _carry_late(self, here: socket.socket) -> None:
        threading.Event().wait(self._pause_s)
        there = socket.create_connection(self._behind, PATIENCE)
        self._open.append(there)
        back = threading.Thread(target=self._carry, args=(there, here), daemon=True)
        back.start()
        self._carry(here, there)
        back.join()
        for each in (here, there):
            each.close()

    @staticmethod
    def _carry(source: socket.socket, target: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                target.sendall(data)
        with suppress(OSError):
            target.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        # an accept() that waits notices a shutdown, and not a close
        for each in (self._server, *self._open):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
        self._server.close()


def test_a_router_that_takes_longer_than_a_handshake_may_is_given_more_time(
    listener: Ours, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'HANDSHAKE_S', 0.1)
    with closing(SlowRouter(listener, 0.35)) as router:
        with closing(Ours('peer', connect=(router.address,))) as other:
            wait_for(lambda: other.id in listener.links(), 'the link')
        assert router.connections > 1


def a_dial(waits: Poller, retry: Retry, open_s: float) -> dialler.Dial:
    return dialler.Dial(
        (), waits, retry, when_connected=lambda *_: None, when_failed=lambda _: None, open_s=open_s
    )


def test_handshakes_that_fail_get_more_time_and_longer_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    pauses: list[float] = []
    waits = Poller('it')
    monkeypatch.setattr(waits, 'call_later', lambda pause, _: pauses.append(pause))
    monkeypatch.setattr(dialler, '_shorten', lambda pause: pause)
    dial = a_dial(waits, Retry(0.1, 0.4), open_s=60.0)
    times = [dial.handshake_s]
    for _ in range(8):
        dial.note_refusal(took_too_long=True)
        times.append(dial.handshake_s)
    assert times == [10, 20, 40, 60, 60, 60, 60, 60, 60]
    assert pauses == [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 4.0, 4.0]
    dial.start()  # it has no address, so the round fails without a handshake
    assert pauses.pop() == 0.4
    dial.note_success()
    assert dial.handshake_s == 10
    dial.note_refusal(took_too_long=False)
    assert pauses.pop() == 0.1
    assert dial.handshake_s == 10  # time was not what it lacked
    assert a_dial(waits, Retry(), open_s=1.0).handshake_s == 1
    waits.close()


@pytest.mark.parametrize('mode', ['silent', 'hangs up'])
def test_an_address_without_a_handshake_does_not_keep_a_client_from_the_next(
    listener: Ours, monkeypatch: pytest.MonkeyPatch, mode: str
) -> None:
    monkeypatch.setattr(bounds, 'HANDSHAKE_S', 1.0)
    monkeypatch.setattr(native_session, 'CONNECTING_S', PATIENCE)
    with socket.create_server(('127.0.0.1', 0)) as server:

        def hang_up() -> None:
            with suppress(OSError):
                while True:
                    server.accept()[0].close()

        if mode == 'hangs up':
            threading.Thread(target=hang_up, daemon=True).start()
        addresses = f'tcp/127.0.0.1:{server.getsockname()[1]}', listener.protocol.gossip.locators[0]
        try:
            with closing(Ours('client', connect=addresses)) as client:
                assert client.links() == {listener.id}
        finally:
            server.shutdown(socket.SHUT_RDWR)  # an accept() that waits notices it, and not a close


def test_sessions_that_lose_their_router_at_once_dial_it_again_at_different_times(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pauses: list[float] = []
    waits = Poller('it')
    monkeypatch.setattr(waits, 'call_later', lambda pause, _: pauses.append(pause))
    for _ in range(200):
        a_dial(waits, Retry(1.0), open_s=10.0).try_again()
    assert 0.5 <= min(pauses) < 0.6
    assert 0.9 < max(pauses) <= 1.0
    waits.close()


def test_nodes_of_gossip_are_dialled_a_few_at_a_time(
    listener: Ours, monkeypatch: pytest.MonkeyPatch, warnings: list[str]
) -> None:
    """Each accepts and says nothing, so that it holds its place until its handshake has taken too long."""
    monkeypatch.setattr(bounds, 'HANDSHAKE_S', 0.2)
    monkeypatch.setattr(dials, '_TO_NODES', Retry(0.05, 0.05, rounds=1))
    listener.session._dials._slots = DialSlots(4)
    most = 0
    with socket.create_server(('127.0.0.1', 0), backlog=128) as mute:
        where = f'tcp/127.0.0.1:{mute.getsockname()[1]}'

        def meet_all() -> None:
            for at in range(12):
                listener.session.meet(Node(bytes((1, at + 1)), Role.PEER, (where,)))

        listener.session._poller.call(meet_all)

        def is_done() -> bool:
            nonlocal most
            under_way = listener.session._dials
            most = max(most, len(under_way._dialled))
            return sum('took too long' in each for each in warnings) >= 2 and not under_way._dials

        wait_for(is_done, 'all of them')
    assert 0 < most <= 4


def test_names_of_gossip_are_looked_up_by_a_few_threads(
    listener: Ours, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    gate = threading.Event()

    def slow(endpoint: Endpoint, *, passive: bool = False) -> list[object]:
        asked.append(endpoint.host)
        assert gate.wait(PATIENCE)
        return []

    monkeypatch.setattr(dialler, 'resolve', slow)
    monkeypatch.setattr(dialler, 'is_quickly_resolved', lambda _: False)
    monkeypatch.setattr(dials, '_TO_NODES', Retry(0.05, 0.05, rounds=1))
    before = threading.active_count()
    done = threading.Event()

    def meet_all() -> None:
        for at in range(30):
            listener.session.meet(Node(bytes((1, at + 1)), Role.PEER, (f'tcp/robot{at}:1',)))
        done.set()

    listener.session._poller.call(meet_all)
    assert done.wait(PATIENCE)
    wait_for(lambda: len(asked) == bounds.MOST_LOOK_UPS, 'the first names')
    assert threading.active_count() == before + bounds.MOST_LOOK_UPS
    gate.set()
    wait_for(lambda: len(asked) == 30 and threading.active_count() == before, 'all names')


def test_a_client_that_asks_and_reads_nothing_does_not_hold_up_its_server(
    listener: Ours, warnings: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'UNREAD_LIMIT', 8 << 20)
    monkeypatch.setattr(bounds, 'UNREAD_S', 0.2)
    listener.serve('k', None)
    stranger = Stranger(listener)
    stranger.shake_hands()
    wait_for(lambda: listener.protocol.links, 'the link')
    for number in range(40):
        stranger.says(b'\x25' + encode_z(5 + number) + b'\xbc' + encode_z(number + 1) + REST_OF_REQUEST)
    wait_for(lambda: len(listener.held) == 40, 'the requests')
    began = monotonic()
    for query in listener.held:  # on this thread, as the executor of a service
        query.answer('k', bytes(1 << 20))
    assert monotonic() - began < 5
    assert 'nothing was taken for 0.2 s' in warnings[0]
    assert stranger.is_hung_up()


REST_OF_REQUEST = bytes.fromhex('00 01 6b 21 0d 03')
"""The bytes behind the number of a REQUEST for the key k, whose answers are not to be dropped."""


def test_pieces_of_a_link_that_ends_are_let_go(listener: Ours) -> None:
    stranger = Stranger(listener)
    stranger.shake_hands()
    wait_for(lambda: listener.protocol.links, 'the link')
    for channel in range(8):
        more = fragment_head(2 * channel + 1, 5, marks_first=True, more=True)
        stranger.says(more + bytes(40_000))
    wait_for(lambda: listener.protocol.pieces.used == 8 * 40_000, 'the pieces')
    stranger.socket.close()
    wait_for(lambda: listener.protocol.pieces.used == 0, 'the end')
