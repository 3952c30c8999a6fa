"""Where the stand-ins are put, and that they go again."""

from __future__ import annotations

import importlib
import queue
import sys
import threading
import time
from pathlib import Path
from time import monotonic as my_monotonic
from time import sleep as my_sleep

import pytest

from goalwire.testing import VirtualClock


def test_names_that_a_module_imported_before_go_by_virtual_time_too(clock: VirtualClock) -> None:
    before = my_monotonic()
    my_sleep(60.0)
    assert my_monotonic() - before == 60.0


def test_after_the_block_everything_is_as_it_was() -> None:
    def names() -> list[object]:
        return [
            time.sleep,
            time.time,
            time.monotonic,
            threading.Lock,
            threading.Thread.start,
            queue.SimpleQueue,
        ]

    before = names()
    with VirtualClock() as clock:
        assert time.sleep is not before[0]
        time.sleep(5.0)
    assert clock.elapsed == 5.0
    assert all(one is other for one, other in zip(before, names(), strict=True))
    assert my_sleep is time.sleep


def test_modules_that_are_imported_meanwhile_go_by_virtual_time_too(
    clock: VirtualClock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (
        'from _thread import allocate_lock\nfrom threading import Lock\nfrom time import monotonic, sleep\n'
    )
    (tmp_path / 'imported_meanwhile.py').write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    module = importlib.import_module('imported_meanwhile')
    before = module.monotonic()
    for make in (module.allocate_lock, module.Lock):
        lock = make()
        assert lock.acquire()
        assert not lock.acquire(timeout=100.0)
    module.sleep(100.0)
    assert module.monotonic() - before == clock.elapsed == 300.0


def test_the_standard_library_and_the_test_runner_keep_the_real_ones(clock: VirtualClock) -> None:
    import subprocess

    from _pytest import timing

    assert subprocess._time is not time.monotonic  # type: ignore[attr-defined]
    assert timing.perf_counter is not time.perf_counter


def test_a_module_that_gets_a_name_between_two_blocks_is_looked_through_again() -> None:
    module = type(sys)('module_of_this_test')
    sys.modules['module_of_this_test'] = module
    try:
        with VirtualClock():
            pass
        module.pause = time.sleep  # type: ignore[attr-defined]
        with VirtualClock() as clock:
            module.pause(5.0)
            assert clock.elapsed == 5.0
        assert module.pause is time.sleep
    finally:
        del sys.modules['module_of_this_test']
