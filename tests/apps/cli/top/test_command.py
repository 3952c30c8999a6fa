"""goalwire top as people run it: the whole command on a terminal, beside a humanoid."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.robot import humanoid, robot_env
from helpers.wires import DDS, require

if sys.platform == 'win32':
    pytest.skip('terminals of POSIX', allow_module_level=True)

from helpers.screens import CTRL_C, Screen, screen

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

SIZE = 130, 32
OF_THE_ROBOT = 'PYTHONPATH', 'GOALWIRE_INTERFACE_PATH', 'HUMANOID_PHYSICS'
F2, F7, DOWN, DELETE = b'\x1bOQ', b'\x1b[18~', b'\x1b[B', b'\x1b[3~'
LEFT_ALTERNATE_SCREEN = '\x1b[?1049l'


@pytest.fixture(scope='module', params=['rmw_zenoh_cpp', pytest.param(DDS, marks=pytest.mark.long)])
def world(request: pytest.FixtureRequest) -> dict[str, str]:
    """A world of these programs. What top shows comes from `observe`, which is tested on each wire."""
    require(request.param)
    return isolated_env(request.param)


@pytest.fixture(scope='module')
def robot(world: dict[str, str]) -> Iterator[dict[str, str]]:
    """A humanoid that is up; its environment."""
    env = world | {name: robot_env()[name] for name in OF_THE_ROBOT}
    with humanoid('up', env=env) as up:
        for _ in range(4):
            up.expect('(Service|Server) ready')
        yield env


def fill(shown: Screen, text: bytes) -> None:
    """Replace the text of a form, and go on to the confirmation."""
    shown.press(F7)
    shown.press(DELETE)
    shown.sees(r'▔▎ │\n[ │]+▊ {40,}▎')  # its first line is empty
    shown.press(text)
    shown.sees(text.decode().splitlines()[-1].replace('[', r'\[').replace('{', r'\{'))
    shown.press(F2)
    shown.sees('y sends it; any other key goes back')


def choose(shown: Screen, tab: bytes, name: str) -> None:
    """Leave one name on a tab, however much else the robot has."""
    shown.press(tab)
    shown.sees(f'(?m)^ /{name}')
    shown.press(b'/')
    shown.sees('show names with')
    shown.press(name.encode())
    shown.sees(f'filter: {name}')
    shown.sees(rf'\n +{name}')  # in the field
    shown.press(b'\r')
    shown.misses(rf'\n +{name}')  # the field is closed


def send_goal(shown: Screen, name: str, goal: bytes) -> str:
    """Send a goal to an action; its id."""
    shown.sees('/arm_action_server')
    choose(shown, b'4', name)
    shown.press(b'g')
    shown.sees(f'send a goal to /{name}')
    fill(shown, goal)
    shown.press(b'y')
    return shown.sees('has accepted the goal ([0-9a-f]{32})')[1]


def test_it_shows_a_robot_and_calls_it(robot: dict[str, str]) -> None:
    with screen(robot, 'top', size=SIZE) as shown:
        shown.sees(r'\d+ nodes, \d+ topics, \d+ services, \d+ actions')
        shown.sees(r'/navigation_action_server +\d')
        shown.press(b'2')
        shown.sees(r'/joint_states +\d+(\.\d+)? +\d+(\.\d+)? KB +1 +')
        choose(shown, b'3', 'get_joint_state')
        shown.press(b'c')
        shown.sees("joint_name: ''")
        fill(shown, b'joint_name: left_arm_elbow')
        shown.press(b'y')
        shown.sees('/get_joint_state answered in .* ms')
        shown.sees(r'/get_joint_state +1 +\d +1 +.* top ')
        shown.press(b'q')
        assert shown.wait() == 0
        assert LEFT_ALTERNATE_SCREEN in shown.text
    assert 'Traceback' not in shown.text


def test_it_sends_a_goal_follows_it_and_cancels_it(robot: dict[str, str]) -> None:
    with screen(robot, 'top', size=SIZE) as shown:
        goal = b'{timeout: 120, target_pose: {pose: {position: {x: 40.0}, orientation: {w: 1.0}}}}'
        goal_id = send_goal(shown, 'move_to_position', goal)
        shown.sees(f'{goal_id[:8]} +EXECUTING +.*[1-9] %')
        shown.press(b'q')
        shown.sees('goals that were sent from here go on')
        shown.sees('q leaves without them')
        shown.press(b'n')
        shown.misses('q leaves without them')
        shown.press(DOWN)
        shown.press(b'x')
        shown.sees(f'cancel the goal {goal_id} of /move_to_position')
        shown.sees('y sends it')
        shown.press(b'y')
        shown.sees(f'the goal {goal_id} of /move_to_position has ended: CANCELED')
        shown.sees(f'{goal_id[:8]} +CANCELED')
        shown.press(b'q')
        assert shown.wait() == 0
    assert 'Traceback' not in shown.text


@pytest.mark.parametrize('how', ['ctrl-c', 'SIGINT', 'SIGTERM'])
def test_it_puts_the_terminal_back_in_order(robot: dict[str, str], how: str) -> None:
    with screen(robot, 'top', size=SIZE) as shown:
        before = shown.modes()
        shown.sees('/arm_action_server')
        assert shown.modes() != before
        if how == 'ctrl-c':
            shown.press(CTRL_C)
        else:
            shown.process.send_signal(signal.Signals[how])
        assert shown.wait() == {'ctrl-c': 130, 'SIGINT': 130, 'SIGTERM': 143}[how]
        assert LEFT_ALTERNATE_SCREEN in shown.text
        assert shown.modes() == before
    assert 'Traceback' not in shown.text


@pytest.mark.parametrize('ignored', [False, True])
def test_it_ends_when_the_terminal_is_closed(robot: dict[str, str], ignored: bool) -> None:
    """Whether SIGHUP tells it, or nothing does, as under nohup."""
    with screen(robot, 'top', size=SIZE, ignores_hangup=ignored) as shown:
        shown.sees('/arm_action_server')
        shown.close()
        assert shown.wait() == 143


def test_a_goal_that_goes_on_is_told_when_it_is_ended_by_a_signal(robot: dict[str, str]) -> None:
    with screen(robot, 'top', size=SIZE) as shown:
        goal = b'{joint_names: [left_arm_elbow], positions: [0.1], duration: 600.0}'
        goal_id = send_goal(shown, 'move_arm', goal)
        shown.press(CTRL_C)
        assert shown.wait() == 130
        shown.expect(f'the goal {goal_id} of /move_arm goes on')
    CommandLine(robot).ok('action', 'cancel', '/move_arm', goal_id)


def test_without_a_terminal_it_says_what_else_there_is(world: dict[str, str]) -> None:
    ros2 = CommandLine(world)
    assert ros2.fails('top', code=10) == (
        'ros2: top needs a terminal that it can draw on; '
        'use: ros2 node list, topic hz, service list, action watch'
    )
    with screen(world, 'top', TERM='dumb') as shown:
        shown.expect('needs a terminal')
        assert shown.wait() == 10


def test_without_textual_it_says_how_to_get_it(world: dict[str, str]) -> None:
    code = (
        'import sys; sys.modules["textual"] = None; from goalwire.apps.cli.main import run_command;'
        'sys.exit(run_command("goalwire", ["top"]))'
    )
    done = subprocess.run(
        [sys.executable, '-c', code], env=world, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (
        10,
        "goalwire: top is drawn by Textual, which is not installed; run: pip install 'goalwire[top]'\n",
    )


def test_no_other_command_imports_textual() -> None:
    code = (
        'import sys; from contextlib import suppress; from goalwire.apps.cli.framework import nouns\n'
        'for name in nouns.NOUNS: nouns.load(name)\n'
        'from goalwire.apps.cli.main import run_command\n'
        'run_command("ros2", ["top", "--help"])\n'
        'print([name for name in sys.modules if name in {"textual", "rich"}])'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == '[]'


def test_names_of_peers_do_not_steer_it(world: dict[str, str], workshop: Program) -> None:
    """The workshop's state has an escape sequence in it."""
    with screen(world, 'top', size=SIZE) as shown:
        shown.sees('/lab/workshop')
        choose(shown, b'2', 'lab/state')
        shown.press(b'e')
        shown.sees(r'data: "ready \\e\[31m"')
        assert '\x1b[31m' not in shown.text
        shown.press(b'q')
        assert shown.wait() == 0
