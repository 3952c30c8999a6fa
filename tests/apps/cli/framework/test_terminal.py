"""Commands on a terminal: a bar, a live table, colours, and Ctrl-C as the keyboard sends it."""

from __future__ import annotations

import sys

import pytest
from helpers.command_line import Begin, CommandLine
from helpers.processes import Program

from goalwire.apps.cli.commands.topic.plot import curve_text

if sys.platform == 'win32':
    pytest.skip('terminals of POSIX', allow_module_level=True)

from helpers.screens import CTRL_C, screen


def test_a_goal_draws_its_bar_and_ctrl_c_cancels_it(ros2: CommandLine, world: dict[str, str]) -> None:
    goal = ['action', 'send_goal', 'lab/fibonacci', 'order=1005', '--progress', 'sequence/10']
    with screen(world, *goal) as shown:
        shown.expect('█{9}░{21}  30 %')
        shown.press(CTRL_C)
        shown.expect('Canceling goal...\r\n')
        shown.expect('Goal canceled.\r\n')
        assert shown.wait() == 9
    assert 'Traceback' not in shown.text


def test_watch_is_a_table_that_is_drawn_anew(ros2: CommandLine, world: dict[str, str], begin: Begin) -> None:
    with screen(world, 'action', 'watch', 'lab/fibonacci', '--progress', 'sequence/10') as shown:
        shown.expect('/lab/fibonacci: 0 active')
        goal = begin('action', 'send_goal', 'lab/fibonacci', 'order=1005')
        goal_id = goal.expect('Goal accepted with ID: ([0-9a-f]{32})')[1]
        shown.expect(f'\x1b\\[36m{goal_id[:8]}  EXECUTING')
        shown.expect('█{9}░{21}  30 %')
        ros2.ok('action', 'cancel', 'lab/fibonacci', goal_id)
        shown.expect(f'\x1b\\[33m{goal_id[:8]}  CANCELED')
        shown.press(CTRL_C)
        assert shown.wait() == 130


def test_plot_draws_fields_and_needs_a_terminal(
    ros2: CommandLine, world: dict[str, str], sensor: Program
) -> None:
    with screen(world, 'topic', 'plot', '/point.point.x', '/point.point.y', '--seconds', '2') as shown:
        shown.expect(r'/point\.point\.x: \d+')
        shown.expect('│ *[▁▂▃▄▅▆▇█]')
        shown.expect(r'/point\.point\.y: 0')
        shown.press(CTRL_C)
        assert shown.wait() == 130
    told = ros2.fails('topic', 'plot', '/point.point.x', code=10)
    assert 'needs a terminal that it can draw on; use: ros2 topic echo' in told
    with screen(world, 'topic', 'plot', '/point.nothing') as shown:
        shown.expect("there is no 'nothing'; its fields are: header, point")
        assert shown.wait() == 4


def test_a_curve_rises_from_its_lowest_to_its_highest() -> None:
    points = [(0.0, 1.0), (5.0, 2.0), (9.9, 3.0)]
    lines = curve_text(points, 0.0, 10.0, columns=22, rows=2)
    assert lines[0].startswith('          3│')
    assert lines[1].startswith('          1│▁')
    assert lines[0].endswith('█')
    assert curve_text([], 0.0, 1.0, columns=22, rows=2) == ['           │'] * 2


def test_colours_are_turned_off_by_no_color(world: dict[str, str]) -> None:
    with screen(world, 'doctor', '--no-self-test', '-rf') as shown:
        shown.expect('\x1b\\[32mall is well\x1b\\[0m')
    with screen(world, 'doctor', '--no-self-test', '-rf', NO_COLOR='1') as shown:
        shown.expect('(?<!m)all is well\r\n')
    with screen(world, 'doctor', '--no-self-test', '-rf', TERM='dumb') as shown:
        shown.expect('(?<!m)all is well\r\n')


def test_what_a_peer_sends_does_not_steer_the_terminal(ros2: CommandLine, world: dict[str, str]) -> None:
    with screen(world, 'topic', 'echo', '/lab/state', '--once', '--field', 'data') as shown:
        shown.expect('ready ')
        assert shown.wait() == 0
        shown.expect('---')
    assert '\x1b' not in shown.text
