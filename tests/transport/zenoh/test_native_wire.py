"""The wire of the ROS layer on a session of ours: waiting for room, and whom opening must reach."""

from __future__ import annotations

import select
from collections.abc import Iterator
from threading import Event, Thread

import pytest
from helpers.patience import PATIENCE, wait_for
from helpers.zenoh_sides import Ours, address

from goalwire.errors import TransportError
from goalwire.transport.zenoh.native_wire import NativeWire
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.settings import Settings
from goalwire.zenoh.protocol.channels import Buffer
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.network import Target
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT
from goalwire.zenoh.protocol.querier import Querier

MEGABYTE = 1 << 20


class Reader:
    """A session that reads nothing more once it has got a message, until it may go on."""

    def __init__(self) -> None:
        self.where = address()
        self.may_go_on, self.is_stopped = Event(), Event()
        self.side = Ours('peer', listen=(self.where,))
        self.side.protocol.declare_subscriber('a', self._take)

    def _take(self, _: object) -> None:
        self.is_stopped.set()
        assert self.may_go_on.wait(PATIENCE)


@pytest.fixture
def reader() -> Iterator[Reader]:
    made = Reader()
    yield made
    made.may_go_on.set()
    made.side.close()


def put_waiting(wire: NativeWire, megabytes: int) -> None:
    """Send a message that the only link has no room for, as the thread of that link does."""
    publisher = wire.declare_publisher('a', reliable=True, waits=False)
    ((_, send),) = publisher.put_where_free(bytes(megabytes * MEGABYTE), b'', (), waits=True)
    send()


def test_a_large_message_has_left_room_for_others_when_its_thread_goes_on(reader: Reader) -> None:
    """Else small ones behind it would be dropped, though nothing is lost on the way."""
    wire = NativeWire(Settings(listen=(), connect=(reader.where,), must_connect=True, connecting_s=PATIENCE))
    small = wire.declare_publisher('a', reliable=True, waits=False)
    (link,) = wire.session.protocol.links
    left_room: list[bool] = []

    def has_room() -> bool:
        return link.outgoing.queue.size <= QUEUE_LIMIT

    def put_large() -> None:
        put_waiting(wire, 32)
        left_room.append(has_room())

    thread = Thread(target=put_large)
    try:
        small.put(b'stop', attachment=b'')
        assert reader.is_stopped.wait(PATIENCE)
        thread.start()
        wait_for(lambda: not has_room(), 'a full queue')
        reader.may_go_on.set()
        thread.join(PATIENCE)
        assert left_room == [True]
    finally:
        reader.may_go_on.set()
        wire.close()


def test_who_waits_for_room_goes_on_though_another_publisher_made_it(
    reader: Reader, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A large message fills the queue, and its own thread empties that, without the socket being full."""
    reader.may_go_on.set()
    wire = NativeWire(Settings(listen=(), connect=(reader.where,), must_connect=True, connecting_s=PATIENCE))
    small = wire.declare_publisher('a', reliable=True, waits=True)
    (link,) = wire.session.protocol.links
    socket_link = wire.session._links[link]
    is_filled, done = Event(), Event()
    real = socket_link.write_many

    def write_all(buffers: list[Buffer]) -> int:
        """Send everything, once somebody waits for room."""
        is_filled.set()
        if link.outgoing.queue.size > QUEUE_LIMIT:
            wait_for(lambda: socket_link.waiting, 'somebody who waits')
        wait_for(lambda: select.select([], [socket_link._fd], [], 0)[1], 'room')
        return real(buffers)

    def put_small() -> None:
        small.put(b'x', attachment=b'')
        done.set()

    monkeypatch.setattr(socket_link, 'write_many', write_all)
    threads = [
        Thread(target=put_waiting, args=(wire, 4)),
        Thread(target=put_small),
    ]
    try:
        threads[0].start()
        assert is_filled.wait(PATIENCE)
        threads[1].start()
        assert done.wait(PATIENCE)
    finally:
        for thread in threads:
            thread.join()
        wire.close()


@pytest.mark.parametrize('role', [Role.PEER, Role.CLIENT])
def test_one_that_must_connect_and_reaches_nobody_does_not_open(role: Role) -> None:
    nowhere = address()
    with pytest.raises(TransportError, match=f'answers at {nowhere}: .*; plug it in$'):
        NativeWire(Settings(role=role, listen=(), connect=(nowhere,), must_connect=True, advice='plug it in'))


@pytest.mark.parametrize('role', [Role.PEER, Role.CLIENT])
def test_one_that_need_not_connect_opens(role: Role) -> None:
    where = address()
    wire = NativeWire(
        Settings(role=role, listen=(), connect=(where,), must_connect=False, retry=Retry(0.05, 0.1))
    )
    late = Ours('router' if role is Role.CLIENT else 'peer', listen=(where,))
    try:
        wait_for(lambda: wire.id in late.links(), 'the link')
    finally:
        wire.close()
        late.close()


def test_one_with_time_goes_on_until_it_has_connected() -> None:
    where, opened = address(), []

    def open_wire() -> None:
        opened.append(
            NativeWire(
                Settings(
                    listen=(), connect=(where,), must_connect=True, connecting_s=60, retry=Retry(0.05, 0.1)
                )
            )
        )

    thread = Thread(target=open_wire)
    thread.start()
    late = Ours('peer', listen=(where,))
    try:
        thread.join(PATIENCE)
        (wire,) = opened
        wait_for(lambda: wire.id in late.links(), 'the link')
        wire.close()
    finally:
        late.close()


def test_times_of_queries_that_have_ended_leave_no_timer_behind() -> None:
    """One query goes on for long, while others come and run out of time."""
    wire = NativeWire(Settings(listen=(), connect=()))
    held: list[object] = []
    try:
        wire.declare_queryable('a', held.append)  # it answers none
        querier = Querier(wire.session.protocol, 'a', target=Target.ALL)
        querier.ask(None, None, lambda _: None, lambda: None, 600.0)
        for _ in range(300):
            ended = Event()
            querier.ask(None, None, lambda _: None, ended.set, 0.001)
            assert ended.wait(PATIENCE)
        assert len(held) == 301
        assert len(wire.session._poller._timers) < 150
    finally:
        wire.close()
