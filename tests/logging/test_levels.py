from __future__ import annotations

import threading

import pytest

from goalwire.logging import LoggingSeverity as Severity
from goalwire.logging import get_logger_effective_level, get_logger_level, levels, set_logger_level


def test_a_logger_without_a_level_is_unset_and_effectively_info() -> None:
    assert get_logger_level('a') is Severity.UNSET
    assert get_logger_effective_level('a') is Severity.INFO


def test_a_child_inherits_from_its_nearest_ancestor() -> None:
    set_logger_level('p', Severity.ERROR)
    set_logger_level('p.c', Severity.DEBUG)
    assert get_logger_effective_level('p.x.y') is Severity.ERROR
    assert get_logger_effective_level('p.c.y') is Severity.DEBUG
    assert get_logger_effective_level('px') is Severity.INFO


def test_a_level_set_later_reaches_children_that_were_asked_before() -> None:
    assert get_logger_effective_level('p.c') is Severity.INFO
    set_logger_level('p', Severity.FATAL)
    assert get_logger_effective_level('p.c') is Severity.FATAL


def test_unset_returns_to_the_inherited_level() -> None:
    set_logger_level('p', Severity.ERROR)
    set_logger_level('p', Severity.UNSET)
    assert get_logger_effective_level('p') is Severity.INFO


def test_the_empty_name_is_the_root_of_all() -> None:
    set_logger_level('', Severity.ERROR)
    assert get_logger_effective_level('any.logger') is Severity.ERROR
    assert get_logger_level('any.logger') is Severity.UNSET


def test_an_unset_root_lets_everything_pass_as_in_ros() -> None:
    set_logger_level('', Severity.UNSET)
    assert get_logger_level('') is Severity.UNSET
    assert get_logger_effective_level('any.logger') is Severity.UNSET
    set_logger_level('', Severity.INFO)


@pytest.mark.parametrize('level', [5, 99])
def test_a_number_that_is_no_severity_is_refused(level: int) -> None:
    with pytest.raises(ValueError, match=f'{level} is not a valid LoggingSeverity'):
        set_logger_level('a', level)


def test_levels_of_many_names_are_not_remembered_for_ever() -> None:
    for number in range(3000):
        get_logger_effective_level(f'goal_{number}')
    assert len(levels._effective) <= levels._CACHE_LIMIT


def test_a_level_holds_while_other_threads_ask() -> None:
    stop = threading.Event()
    seen: set[Severity] = set()

    def ask() -> None:
        while not stop.is_set():
            seen.add(get_logger_effective_level('p.c'))

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(300):
            set_logger_level('p', Severity.ERROR)
            assert get_logger_effective_level('p.c') is Severity.ERROR
            set_logger_level('p', Severity.DEBUG)
            assert get_logger_effective_level('p.c') is Severity.DEBUG
    finally:
        stop.set()
        for thread in threads:
            thread.join()
    assert seen <= {Severity.INFO, Severity.ERROR, Severity.DEBUG}


def test_the_root_has_a_level_of_its_own() -> None:
    assert get_logger_level('') is Severity.INFO
    set_logger_level('', Severity.ERROR)
    assert get_logger_level('') is Severity.ERROR
