"""The thread that waits for messages: an idle one if there is one, else the session's own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from functools import partial
from queue import SimpleQueue
from time import monotonic, monotonic_ns
from typing import Self

import pytest
from helpers.held_up import HeldUp
from helpers.patience import PATIENCE

from goalwire.concurrency.wire_poller import Sleeper
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.waiters import Waiter, WireWaiter
from goalwire.rules.qos import QoS
from goalwire.transport.dds.cyclone.context import DOMAINS, open_domain
from goalwire.transport.dds.cyclone.delivery import ReaderDispatcher
from goalwire.transport.dds.cyclone.library import load
from goalwire.transport.dds.cyclone.qos import endpoint_qos
from goalwire.transport.dds.cyclone.waitset import CLOSING_S, DdsWirePoller
from goalwire.transport.dds.cyclone.wire import Participant, RawSample, Reader, Writer

OWN = 'goalwire-test-io'


class Post:
    """A reader that a wire poller watches, and a writer to it that delivers nothing itself."""

    def __init__(self, participant: Participant) -> None:
        with endpoint_qos(participant.library, QoS(), b'') as qos:
            self._writer = Writer(participant, 'rt/post', 'test::msg::dds_::Letter_', qos)
            reader = Reader(participant, 'rt/post', 'test::msg::dds_::Letter_', qos)
        self._deliverers: SimpleQueue[str] = SimpleQueue()
        self.on_letter: Callable[[], object] = bool
        self.wire_poller = DdsWirePoller(participant, OWN)
        self.wire_poller.watch(reader.condition, ReaderDispatcher(reader, 'post', self._delivered).drain)

    def _delivered(self, _: RawSample) -> None:
        self._deliverers.put(threading.current_thread().name)
        self.on_letter()

    def send(self) -> str:
        """Send a letter; return the name of the thread that brought it."""
        assert self._writer.write(b'\0\1\0\0letter') == 0
        return self._deliverers.get(timeout=PATIENCE)

    def send_until_brought_by(self, name: str) -> None:
        """Send letters until that thread brings one."""
        deadline = monotonic() + PATIENCE
        while (brought_by := self.send()) != name:
            assert monotonic() < deadline, f'{brought_by} goes on leading'


@pytest.fixture
def post(alone: dict[str, str]) -> Iterator[Post]:
    library, domain_id = load(), int(alone['ROS_DOMAIN_ID'])
    open_domain(library, domain_id)
    participant = Participant(library, domain_id, b'')
    post = Post(participant)
    try:
        yield post
    finally:
        post.wire_poller.close()
        participant.close()
        DOMAINS.close(domain_id)


class Idle:
    """A thread that waits in a wire poller until the block ends, as one of an executor does."""

    def __init__(self, wire_poller: DdsWirePoller, name: str) -> None:
        self._vigil = wire_poller
        self.waiter = WireWaiter(ShutdownSignal())
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name=name)

    def _run(self) -> None:
        while not self._stopping:
            self._vigil.wait(self.waiter, None)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopping = True
        self.waiter.wake()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()


def test_where_nobody_waits_the_sessions_own_thread_delivers(post: Post) -> None:
    assert post.send() == OWN


def test_a_thread_that_waits_takes_the_lead_and_keeps_it(post: Post) -> None:
    with Idle(post.wire_poller, 'idle'):
        post.send_until_brought_by('idle')
        assert {post.send() for _ in range(50)} == {'idle'}


def test_a_second_thread_leads_when_the_first_has_left(post: Post) -> None:
    with Idle(post.wire_poller, 'first') as first:
        post.send_until_brought_by('first')
        with Idle(post.wire_poller, 'second'):
            assert {post.send() for _ in range(50)} == {'first'}
            first.__exit__()
            post.send_until_brought_by('second')
            assert post.send() == 'second'


def test_the_own_thread_leads_again_when_everybody_has_left(post: Post) -> None:
    with Idle(post.wire_poller, 'idle'):
        post.send_until_brought_by('idle')
    assert post.send() == OWN


def test_a_delivery_that_wakes_the_leader_ends_its_wait(post: Post) -> None:
    waiter = WireWaiter(ShutdownSignal())
    post.on_letter = waiter.wake
    names = ['']
    deadline = monotonic() + PATIENCE
    while names[-1] != threading.current_thread().name:
        assert monotonic() < deadline
        sender = threading.Thread(target=lambda: names.append(post.send()))
        sender.start()
        assert post.wire_poller.wait(waiter, int(PATIENCE * 1e9))
        sender.join(PATIENCE)


def test_another_thread_wakes_the_leader(post: Post) -> None:
    with Idle(post.wire_poller, 'idle') as idle:
        post.send_until_brought_by('idle')
        held_up, begun = HeldUp(), monotonic()
        idle.__exit__()
        assert monotonic() - begun < 1 + held_up.seconds


def test_a_wait_ends_at_its_time_and_not_before(post: Post) -> None:
    waiter = WireWaiter(ShutdownSignal())
    while True:  # until this thread leads: a wait that only sends the own thread off may end early
        begun = monotonic_ns()
        if not post.wire_poller.wait(waiter, 20_000_000):
            break
    assert monotonic_ns() - begun >= 20_000_000


def test_a_wake_that_came_first_ends_the_wait_at_once(post: Post) -> None:
    waiter = WireWaiter(ShutdownSignal())
    waiter.wake()
    assert post.wire_poller.wait(waiter, None)


class Interrupted(WireWaiter):
    """A sleeper whose sleep a signal's handler interrupts: `handle` is that, and told whether it leads."""

    def __init__(self, handle: Callable[[bool], object]) -> None:
        super().__init__(ShutdownSignal())
        self._handle = handle
        self.take_wake = partial(self.wait_on_lock, 0)

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        self._handle(self.interrupt is not None)
        return Waiter.wait(self, timeout_ns)


def test_what_a_signals_handler_raises_in_a_wait_leaves_the_lead_free(post: Post) -> None:
    leading = [False]

    def handle(leads: bool) -> None:
        leading.append(leads)
        raise KeyboardInterrupt

    while not leading[-1]:
        with pytest.raises(KeyboardInterrupt):
            post.wire_poller.wait(Interrupted(handle), None)
    assert post.send() == OWN


def test_what_a_signals_handler_raises_as_a_thread_lies_down_leaves_no_follower(post: Post) -> None:
    class Interrupting(list[Sleeper]):
        def append(self, sleeper: Sleeper) -> None:
            super().append(sleeper)
            raise KeyboardInterrupt

    post.wire_poller._followers = Interrupting()
    with pytest.raises(KeyboardInterrupt):
        post.wire_poller._follow(WireWaiter(ShutdownSignal()), None)
    assert not post.wire_poller._followers


def test_closing_sends_the_leader_off_and_ends_the_own_thread(post: Post) -> None:
    with Idle(post.wire_poller, 'idle'):
        post.send_until_brought_by('idle')
        held_up, begun = HeldUp(), monotonic()
        post.wire_poller.close()
        assert monotonic() - begun < 1 + held_up.seconds
        assert OWN not in {thread.name for thread in threading.enumerate()}


def test_a_handler_that_closes_while_its_thread_leads_waits_for_nobody(post: Post) -> None:
    leading = [False]

    def handle(leads: bool) -> None:
        leading.append(leads)
        if leads:
            post.wire_poller.close()

    held_up, begun = HeldUp(), monotonic()
    while not leading[-1]:
        post.wire_poller.wait(Interrupted(handle), 1_000_000)
    assert monotonic() - begun < CLOSING_S / 2 + held_up.seconds


def test_after_closing_a_wait_is_a_sleep_that_a_wake_ends(post: Post) -> None:
    post.wire_poller.close()
    waiter = WireWaiter(ShutdownSignal())
    assert not post.wire_poller.wait(waiter, 1_000_000)
    waker = threading.Timer(0.01, waiter.wake)
    waker.start()
    assert post.wire_poller.wait(waiter, None)
    waker.join()


def test_for_dependants_the_own_thread_leads_as_soon_as_the_leader_leaves(post: Post) -> None:
    with Idle(post.wire_poller, 'idle') as idle:
        post.send_until_brought_by('idle')
        post.wire_poller.external_sleepers.add('a loop')
        assert post.send() == 'idle'  # who leads goes on until it has work
        idle.__exit__()
    assert {post.send() for _ in range(5)} == {OWN}
    waiter = WireWaiter(ShutdownSignal())
    keeper_waits = threading.Thread(target=post.wire_poller.wait, args=(waiter, None), name='late')
    keeper_waits.start()
    assert {post.send() for _ in range(20)} == {OWN}
    waiter.wake()
    keeper_waits.join(PATIENCE)
