"""The look before a sleep: when there is one, and that it ends where it does not pay. Time is made up."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from goalwire.errors import TransportError
from goalwire.transport import wire_poller
from goalwire.transport.wire_poller import DEFAULT_LOOK_US, FOREVER, LeaderFollowers, Look, look_ns

LONGEST_NS = 50_000
STEP_NS = 1000
NEVER = 10**9


class Wire:
    """A wire on which something comes after so many looks; each takes a step of time."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 10**12
        self.waits: list[int] = []
        self.comes_after = NEVER
        self.stolen_ns = 0
        self.awaited: list[None] = []
        self.served = 0
        self.on_sleep: Callable[[], int] = lambda: 0
        monkeypatch.setattr(wire_poller, 'monotonic_ns', lambda: self.now)
        monkeypatch.setattr(wire_poller, 'let_others_run', self._let_others_run)

    def _let_others_run(self) -> None:
        self.now += self.stolen_ns

    def wait(self, timeout_ns: int) -> int:
        self.waits.append(timeout_ns)
        self.now += STEP_NS
        if timeout_ns:
            return self.on_sleep()
        self.comes_after -= 1
        if self.comes_after >= 0:
            return 0
        self.comes_after = NEVER
        return 2

    def serve(self, found: int) -> None:
        self.served += found

    def interrupt(self) -> None: ...

    def descriptor(self) -> int | None:
        return None

    def next_due(self) -> float:
        return float('inf')

    def looks(self) -> int:
        """How often it was looked at since the last time that this was asked."""
        count = len([timeout for timeout in self.waits if not timeout])
        self.waits.clear()
        return count


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> Wire:
    return Wire(monkeypatch)


@pytest.fixture
def look(fake: Wire) -> Look:
    return Look(fake.wait, LONGEST_NS)


def fail(look: Look, fake: Wire) -> None:
    """Look in vain until it looks no more."""
    fake.comes_after = NEVER
    while True:
        assert look() == 0
        if not fake.looks():
            return


def test_what_comes_in_time_is_found(look: Look, fake: Wire) -> None:
    for _ in range(100):
        fake.comes_after = 20
        assert look() == 2
        assert fake.looks() == 21


def test_a_look_ends_in_time(look: Look, fake: Wire) -> None:
    assert look() == 0
    assert 0 < fake.looks() <= LONGEST_NS // STEP_NS + 1


def test_looks_in_vain_end_and_are_tried_ever_more_rarely(look: Look, fake: Wire) -> None:
    fail(look, fake)
    tried = []
    for chance in range(20_000):
        look()
        if fake.looks():
            tried.append(chance)
    assert 10 < len(tried) < 40
    assert tried[-1] - tried[-2] == 1024


def test_looks_that_mostly_succeed_go_on(look: Look, fake: Wire) -> None:
    for chance in range(1000):
        fake.comes_after = NEVER if chance % 5 == 4 else 3
        look()
        assert fake.looks()


def test_one_that_succeeds_again_has_the_next_ones_follow(look: Look, fake: Wire) -> None:
    fail(look, fake)
    while not fake.looks():
        fake.comes_after = 0
        look()
    for _ in range(10):
        fake.comes_after = 0
        assert look() == 2
        assert fake.looks() == 1


def test_where_others_need_the_processor_a_look_has_failed_whatever_it_finds(look: Look, fake: Wire) -> None:
    fake.stolen_ns = 3_000_000
    found = 0
    for _ in range(20):
        fake.comes_after = 1
        found += bool(look())
    assert 0 < found < 5
    fake.looks()
    assert look() == 0
    assert fake.looks() == 0


class Sleeper:
    """A thread that is woken by its second sleep."""

    interrupt: Callable[[], None] | None = None

    def __init__(self, fake: Wire, *found: int) -> None:
        self.sleeps = [*found, 0]
        fake.on_sleep = lambda: self.sleeps.pop(0)

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        assert timeout_ns == 0
        return not self.sleeps

    def wake(self) -> None: ...


def lead(fake: Wire, *found: int) -> list[int]:
    """Lead until it has slept once more than there are results of sleeps; return how long each wait was."""
    poller = LeaderFollowers(fake, 'test')
    fake.waits.clear()
    assert poller.wait(Sleeper(fake, *found), None)
    poller.close_in_child()
    return fake.waits


def test_who_expects_nothing_sleeps_at_once(fake: Wire) -> None:
    assert lead(fake) == [FOREVER]


def test_who_has_been_told_something_looks_before_the_next_sleep(fake: Wire) -> None:
    waits = lead(fake, 1)
    assert waits[0] == waits[-1] == FOREVER
    assert set(waits[1:-1]) == {0}
    assert fake.served == 1


def test_who_has_asked_looks_before_the_first_sleep(fake: Wire) -> None:
    fake.awaited.append(None)
    fake.comes_after = 3
    waits = lead(fake)
    assert waits[:4] == [0, 0, 0, 0]
    assert waits[-1] == FOREVER
    assert fake.served >= 2


def test_nobody_looks_where_it_is_turned_off(fake: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_LOOK_US', '0')
    fake.awaited.append(None)
    assert lead(fake, 1, 1) == [FOREVER] * 3


def test_the_switch() -> None:
    assert look_ns({}) == look_ns({'GOALWIRE_LOOK_US': ''}) == DEFAULT_LOOK_US * 1000
    assert look_ns({'GOALWIRE_LOOK_US': '0'}) == 0
    assert look_ns({'GOALWIRE_LOOK_US': '120'}) == 120_000


@pytest.mark.parametrize('text', ['-1', 'off', '1.5', '1001', '50us'])
def test_a_switch_that_says_no_time_is_refused(text: str) -> None:
    with pytest.raises(TransportError, match=f"GOALWIRE_LOOK_US is '{text}'; set it to microseconds from 0"):
        look_ns({'GOALWIRE_LOOK_US': text})
