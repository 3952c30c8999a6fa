"""Log lines of all nodes."""

from __future__ import annotations

from rcl_interfaces.msg import Log

from goalwire.observe.log import LEVELS, LogBook


def test_log_lines_are_found_by_level_node_and_text() -> None:
    book = LogBook()
    for number in range(20):
        level = 40 if number % 10 == 0 else 20
        book.take(Log(level=level, name='arm' if number % 2 else 'leg', msg=f'line {number}'))
    assert [line.text for line in book.latest(3)] == ['line 19', 'line 18', 'line 17']
    assert [line.text for line in book.latest(9, least_level=40)] == ['line 10', 'line 0']
    assert len(book.latest(99, node='arm')) == 10
    assert [line.text for line in book.latest(99, text='LINE 1')][-1] == 'line 1'
    assert book.nodes == ['arm', 'leg']


def test_log_lines_of_any_size_are_cut_and_say_so() -> None:
    book = LogBook()
    size = 10_000_000
    book.take(Log(level=20, name='n' * size, msg='m' * size, file='f' * size, function='g' * size))
    [line] = book.latest(1)
    assert line.text == 'm' * 4000 + '… (10000000 characters)'
    assert len(line.node) + len(line.place) < 1000


def test_lines_that_came_after_a_version_are_told_once() -> None:
    book = LogBook(kept=3)
    for number in range(5):
        book.take(Log(level=20, name='arm' if number % 2 else 'leg', msg=f'line {number}'))
    assert [line.text for line in book.since(0, '')] == ['line 2', 'line 3', 'line 4']
    assert [line.text for line in book.since(4, '')] == ['line 4']
    assert [line.text for line in book.since(0, 'arm')] == ['line 3']
    assert book.since(book.version, '') == []


def test_levels_have_the_names_of_ros_2() -> None:
    assert LEVELS == {10: 'DEBUG', 20: 'INFO', 30: 'WARN', 40: 'ERROR', 50: 'FATAL'}
    book = LogBook()
    book.take(Log(level=35, msg='of no level'))
    assert book.latest(1)[0].level_name == '35'
