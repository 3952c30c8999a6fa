from __future__ import annotations

import pytest

from goalwire.logging import LoggingSeverity, get_logging_severity_from_string


def test_severities_carry_the_numbers_of_rcl_interfaces_log() -> None:
    assert {s.name: s.value for s in LoggingSeverity} == {
        'UNSET': 0,
        'DEBUG': 10,
        'INFO': 20,
        'WARN': 30,
        'ERROR': 40,
        'FATAL': 50,
    }


@pytest.mark.parametrize('text', ['info', 'INFO', 'Info'])
def test_a_severity_is_found_by_its_name_in_any_case(text: str) -> None:
    assert get_logging_severity_from_string(text) is LoggingSeverity.INFO


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(RuntimeError, match=r"Failed to get severity name: 'warning' is not one of .*warn"):
        get_logging_severity_from_string('warning')
