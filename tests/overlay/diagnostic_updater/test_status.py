"""A status: its summary and its values."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from diagnostic_updater import DiagnosticStatusWrapper

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def test_a_summary_is_set_from_a_level_and_a_message_or_from_a_status() -> None:
    status = DiagnosticStatusWrapper()
    status.summary(WARN, 5)
    assert (status.level, status.message) == (WARN, '5')
    status.summary(DiagnosticStatus(level=ERROR, message='hot'))
    assert (status.level, status.message) == (ERROR, 'hot')
    status.clearSummary()
    assert (status.level, status.message) == (OK, '')


@pytest.mark.parametrize(
    ('first', 'second', 'merged'),
    [
        ((OK, 'fine'), (WARN, 'warm'), (WARN, 'warm')),
        ((WARN, 'warm'), (OK, 'fine'), (WARN, 'warm')),
        ((WARN, 'warm'), (ERROR, 'hot'), (ERROR, 'warm; hot')),
        ((ERROR, 'hot'), (WARN, 'warm'), (ERROR, 'hot; warm')),
        ((OK, 'fine'), (OK, 'well'), (OK, 'fine; well')),
        ((OK, ''), (OK, 'well'), (OK, 'well')),
    ],
)
def test_the_higher_level_counts_and_what_is_fine_is_dropped_beside_what_is_not(
    first: tuple[bytes, str], second: tuple[bytes, str], merged: tuple[bytes, str]
) -> None:
    status = DiagnosticStatusWrapper(level=first[0], message=first[1])
    status.mergeSummary(*second)
    assert (status.level, status.message) == merged


def test_values_become_text() -> None:
    status = DiagnosticStatusWrapper()
    status.add('model', 'T-1')
    status.add('teeth', 3)
    status.add('open', True)
    assert status.values == [
        KeyValue(key='model', value='T-1'),
        KeyValue(key='teeth', value='3'),
        KeyValue(key='open', value='True'),
    ]


@pytest.mark.parametrize('args', [(), ('hot',), (2, 'hot'), (WARN, 'hot', 1)])
def test_what_is_not_a_summary_is_refused(args: tuple[object, ...]) -> None:
    status = DiagnosticStatusWrapper(message='as before')
    with pytest.raises(TypeError, match=r'DiagnosticStatus\.WARN'):
        status.summary(*args)  # type: ignore[call-overload]
    assert status.message == 'as before'
