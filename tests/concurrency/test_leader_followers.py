"""The look at the wire before a sleep: when there is one, and that it ends if it does not pay.

Time is made up.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from goalwire.concurrency import leader_followers
from goalwire.concurrency.leader_followers import (
    DEFAULT_LOOK_US,
    FOREVER,
    KEPT,
    RAREST,
    TRIED,
    LeaderFollowers,
    Look,
    look_ns,
)
from goalwire.errors import TransportError

LONGEST_NS = 50_000
STEP_NS = 1000


class Wire:
    """A wire on which something comes some time after the last thing; each look takes a step of time."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 10**12
        self.waits: list[int] = []
        self.comes_after_ns = 0
        self.wake_up_ns = 100_000
        self.stolen_ns = 0
        self.due = 1000 * self.now
        self.awaited: list[None] = []
        self.served = 0
        self.on_sleep: Callable[[], int] = self.sleep
        monkeypatch.setattr(leader_followers, 'monotonic_ns', lambda: self.now)
        monkeypatch.setattr(leader_followers, 'let_others_run', self._let_others_run)

    def _let_others_run(self) -> None:
        self.now += self.stolen_ns

    def send(self) -> None:
        """Have the next thing come."""
        self.due = self.now + self.comes_after_ns

    def wait(self, timeout_ns: int) -> int:
        self.waits.append(timeout_ns)
        self.now += STEP_NS
        if timeout_ns:
            return self.on_sleep()
        return 2 if self.now >= self.due else 0

    def sleep(self) -> int:
        """Sleep until it has come, and be woken."""
        self.now = max(self.now, self.due) + self.wake_up_ns
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


def waits_that_look(look: Look, fake: Wire, count: int) -> list[int]:
    """Wait for so many things; return which of the waits have looked."""
    looked = []
    for number in range(count):
        fake.send()
        assert look(FOREVER) == 2
        if fake.looks():
            looked.append(number)
    return looked


def test_a_look_is_tried_and_stays_where_it_saves_a_wake_up(look: Look, fake: Wire) -> None:
    fake.comes_after_ns = 20_000
    looked = waits_that_look(look, fake, TRIED + 1000)
    assert looked[0] == TRIED
    assert len(looked) > 1000 * KEPT / (KEPT + TRIED) - KEPT


def test_what_is_found_by_a_look_needs_no_sleep(look: Look, fake: Wire) -> None:
    fake.comes_after_ns = 20_000
    waits_that_look(look, fake, TRIED)
    fake.send()
    assert look(FOREVER) == 2
    assert fake.waits == [0] * 20


def test_a_look_ends_in_time_and_sleeps(look: Look, fake: Wire) -> None:
    fake.comes_after_ns = 20_000
    waits_that_look(look, fake, TRIED)
    fake.comes_after_ns = 10 * LONGEST_NS
    fake.send()
    assert look(FOREVER) == 2
    assert fake.waits[-1] == FOREVER
    assert LONGEST_NS // STEP_NS <= len(fake.waits) - 1 <= LONGEST_NS // STEP_NS + 1


def test_looks_in_vain_are_tried_ever_more_rarely(look: Look, fake: Wire) -> None:
    fake.comes_after_ns = 10 * LONGEST_NS
    looked = waits_that_look(look, fake, 20_000)
    assert len(looked) < 250
    begins = [at for at in looked if at - 1 not in looked]
    assert begins[-1] - begins[-2] == RAREST + TRIED


def test_a_stream_that_comes_at_its_own_times_is_slept_for(look: Look, fake: Wire) -> None:
    fake.comes_after_ns, fake.wake_up_ns = LONGEST_NS - 10_000, 5_000
    assert len(waits_that_look(look, fake, 20_000)) < 250


def test_looks_that_pay_again_come_back(look: Look, fake: Wire) -> None:
    fake.comes_after_ns = 10 * LONGEST_NS
    waits_that_look(look, fake, 20_000)
    fake.comes_after_ns = 20_000
    assert len(waits_that_look(look, fake, 20_000)) > 15_000


def test_where_others_take_the_processor_meanwhile_looks_end(look: Look, fake: Wire) -> None:
    fake.comes_after_ns, fake.stolen_ns = 20_000, 3_000_000
    assert len(waits_that_look(look, fake, 20_000)) < 250


def test_a_wait_that_nothing_came_to_says_nothing(look: Look, fake: Wire) -> None:
    fake.on_sleep = lambda: 0
    for _ in range(10 * TRIED):
        assert look(FOREVER) == 0
    assert not fake.looks()


class Sleeper:
    """A thread that is woken by its second sleep."""

    interrupt: Callable[[], None] | None = None

    def __init__(self, fake: Wire, *found: int) -> None:
        self.sleeps = [*found, 0]
        fake.on_sleep = lambda: self.sleeps.pop(0)
        self.take_wake: Callable[[], bool] = lambda: not self.sleeps

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        raise AssertionError(f'the leader sleeps on the wire, not for {timeout_ns} ns on a lock')

    def wake(self) -> None: ...


def lead(fake: Wire, *found: int) -> list[int]:
    """Lead until it has slept once more than there are results of sleeps; return how long each wait was."""
    poller = LeaderFollowers(fake, 'test')
    fake.waits.clear()
    assert poller.wait(Sleeper(fake, *found), None)
    poller.reset_in_child()
    return fake.waits


def test_who_expects_nothing_sleeps_at_once(fake: Wire) -> None:
    assert lead(fake) == [FOREVER]


def test_who_was_told_something_looks_before_it_sleeps(fake: Wire) -> None:
    waits = lead(fake, *[1] * (1 + TRIED))
    assert waits[: 1 + TRIED] == [FOREVER] * (1 + TRIED)
    assert set(waits[1 + TRIED : -1]) == {0}
    assert waits[-1] == FOREVER
    assert fake.served == 1 + TRIED


def test_who_has_asked_looks_before_it_sleeps(fake: Wire) -> None:
    fake.awaited.append(None)
    waits = lead(fake, *[1] * TRIED)
    assert waits[:TRIED] == [FOREVER] * TRIED
    assert set(waits[TRIED:-1]) == {0}
    assert waits[-1] == FOREVER


def test_nobody_looks_where_it_is_turned_off(fake: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_LOOK_US', '0')
    fake.awaited.append(None)
    assert lead(fake, *[1] * 50) == [FOREVER] * 51


def test_the_switch() -> None:
    assert look_ns({}) == look_ns({'GOALWIRE_LOOK_US': ''}) == DEFAULT_LOOK_US * 1000
    assert look_ns({'GOALWIRE_LOOK_US': '0'}) == 0
    assert look_ns({'GOALWIRE_LOOK_US': '120'}) == 120_000


@pytest.mark.parametrize('text', ['-1', 'off', '1.5', '1001', '50us'])
def test_a_switch_that_says_no_time_is_refused(text: str) -> None:
    with pytest.raises(TransportError, match=f"GOALWIRE_LOOK_US is '{text}'; set it to microseconds from 0"):
        look_ns({'GOALWIRE_LOOK_US': text})
