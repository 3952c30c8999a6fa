"""A log is a list of the things that were seen, which can be waited for."""

from __future__ import annotations

import threading

import pytest

from goalwire.testing import Log, VirtualClock


def _filled(*items: int) -> Log[int]:
    log: Log[int] = Log('numbers')
    for item in items:
        log.append(item)
    return log


def test_it_reads_like_a_list() -> None:
    log = _filled(1, 2, 3)
    assert (len(log), log[0], log[-1], log[1:], list(log)) == (3, 1, 3, [2, 3], [1, 2, 3])
    assert log == [1, 2, 3]
    assert log == _filled(1, 2, 3)
    assert log != [1]
    assert not _filled()


def test_who_waits_is_woken_by_what_comes(clock: VirtualClock) -> None:
    log = _filled(1)
    threading.Timer(2.0, log.append, [2]).start()
    assert log.wait_for(2) == [1, 2]
    assert clock.elapsed == 2.0


def test_what_was_seen_is_shown_the_latest_of_it_where_that_is_much(clock: VirtualClock) -> None:
    with pytest.raises(AssertionError, match=r'^wanted 1 numbers within 0\.5 s, got none$'):
        _filled().wait_for(timeout=0.5)
    with pytest.raises(AssertionError) as caught:
        _filled(*range(25)).wait_for(30)
    lines = str(caught.value).splitlines()
    assert lines[0] == 'wanted 30 numbers within 5 s, got 25:'
    assert lines[1:] == [*(f'  {number}' for number in range(15, 25)), '  … and 15 before them']
