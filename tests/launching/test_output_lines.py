"""The lines of a process that is interrupted while it starts."""

from __future__ import annotations

from goalwire.launching.output_lines import Lines

TRACEBACK = b'Traceback (most recent call last):\n  File "a.py", line 1, in <module>\n'


def test_a_traceback_of_the_interrupt_is_dropped() -> None:
    told: list[str] = []
    lines = Lines(told.append, cached=False)
    lines.expect_interrupt()
    lines.feed(TRACEBACK + b'KeyboardInterrupt\n')
    lines.flush()
    assert told == []
    assert lines.was_interrupted_early


def test_another_error_of_the_start_is_told() -> None:
    told: list[str] = []
    lines = Lines(told.append, cached=False)
    lines.expect_interrupt()
    lines.feed(TRACEBACK + b'ValueError: no\n')
    lines.flush()
    assert told == [*TRACEBACK.decode().splitlines(), 'ValueError: no']
    assert not lines.was_interrupted_early


def test_what_is_no_traceback_is_told_at_once() -> None:
    told: list[str] = []
    lines = Lines(told.append, cached=False)
    lines.expect_interrupt()
    lines.feed(b'cleaning up\n')
    assert told == ['cleaning up']


def test_a_program_that_has_begun_keeps_its_traceback() -> None:
    told: list[str] = []
    lines = Lines(told.append, cached=False)
    lines.feed(b'hello\n')
    lines.expect_interrupt()
    lines.feed(TRACEBACK + b'KeyboardInterrupt\n')
    lines.flush()
    assert told[-1] == 'KeyboardInterrupt'
