"""The counts and logs of things that break the rules, and of receivers that fail."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import NamedTuple

import pytest

from goalwire.fault_reports import RejectCounters, report_failure
from goalwire.logging import LoggingSeverity, LogRecord


class EndpointState(NamedTuple):
    title: str
    logger: str = 'lamp'


def test_the_first_of_each_kind_and_endpoint_is_logged_by_its_node(records: list[LogRecord]) -> None:
    rejects = RejectCounters()
    for _ in range(3):
        rejects.add('message', 'no attachment', EndpointState("subscription '/a'"))
        rejects.add('message', 'no attachment', EndpointState("subscription '/b'", 'other'))
    rejects.add('request', 'too short', EndpointState("service '/a'"))
    rejects.add('token', 'no chunks')
    assert [(record.name, record.message.partition(';')[0]) for record in records] == [
        ('lamp', "subscription '/a': a message was ignored (no attachment)"),
        ('other', "subscription '/b': a message was ignored (no attachment)"),
        ('lamp', "service '/a': a request was ignored (too short)"),
        ('goalwire.transport', 'a token was ignored (no chunks)'),
    ]
    assert {record.severity for record in records} == {LoggingSeverity.WARN}
    assert rejects.counts() == {'message': 6, 'request': 1, 'token': 1}


def test_then_powers_of_ten_are(records: list[LogRecord]) -> None:
    rejects = RejectCounters()
    for number in range(1, 2001):
        rejects.add('message', number, EndpointState('here'))
    assert [record.message for record in records] == [
        'here: a message was ignored (1); further ones are counted, and told of at 10, 100, 1000, …',
        'here: a message was ignored, 10 times by now; the last time: 10',
        'here: a message was ignored, 100 times by now; the last time: 100',
        'here: a message was ignored, 1000 times by now; the last time: 1000',
    ]


def test_a_reason_cannot_forge_a_line(records: list[LogRecord]) -> None:
    RejectCounters().add('message', 'x\n[INFO] [1] [robot]: fine\x1b[2J' + 'y' * 10**6, EndpointState('here'))
    assert records[0].message.isprintable()
    assert len(records[0].message) < 700


def test_a_failure_is_logged_with_its_place(records: list[LogRecord]) -> None:
    report_failure("subscription '/chatter'", ZeroDivisionError('by zero'))
    (record,) = records
    assert record.name == 'goalwire.transport'
    assert record.severity is LoggingSeverity.ERROR
    assert "subscription '/chatter'" in record.message
    assert 'ZeroDivisionError: by zero' in record.message


def test_a_failure_that_comes_again_is_told_at_powers_of_ten(records: list[LogRecord]) -> None:
    for _ in range(150):
        report_failure('a', ZeroDivisionError())
    report_failure('b', ZeroDivisionError())
    report_failure('a', ValueError())
    firsts = [record.message.splitlines()[0].rpartition('; ')[2] for record in records]
    lost = 'this delivery is lost'
    assert firsts == [lost, f'{lost} (10 times by now)', f'{lost} (100 times by now)', lost, lost]


class Late(Exception):
    """The error of a program's handler."""


def ring(_number: int, _frame: object) -> None:
    raise Late


class Ringing:
    """A handler that is an object, as goalwire's own is, which calls the program's."""

    def __call__(self, number: int, frame: object) -> None:
        ring(number, frame)


@pytest.mark.parametrize('handler', [ring, Ringing()], ids=['function', 'object'])
def test_what_a_signals_handler_raises_in_a_receiver_goes_to_the_program(
    records: list[LogRecord], handler: Callable[[int, object], None]
) -> None:
    def receive() -> None:
        try:
            signal.raise_signal(signal.SIGALRM)
        except Exception as error:
            report_failure('here', error)

    before = signal.signal(signal.SIGALRM, handler)
    try:
        with pytest.raises(Late):
            receive()
    finally:
        signal.signal(signal.SIGALRM, before)
    assert records == []
