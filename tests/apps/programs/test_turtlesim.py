"""The turtle simulator, as the beginner's pages of ROS 2's documentation use it, command by command."""

from __future__ import annotations

import os
import re
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from apps.programs.conftest import Run
from helpers.browser import chromium
from helpers.command_line import CommandLine
from helpers.isolation import NETWORK, isolated_env
from helpers.markdown import ROOT
from helpers.page import until
from helpers.processes import Program
from helpers.screens import screen

PEN_PIXELS = """() => {
    const all = document.getElementById('window').getContext('2d').getImageData(0, 0, 500, 500).data;
    let count = 0;
    for (let i = 0; i < all.length; i += 4)
        if (all[i] > 0x80 && all[i] < 0xc0 && all[i + 1] > 0x80 && all[i + 2] > 0xe0) count++;
    return count;
}"""
UP = b'\x1b[A'
RUN = (Path('-m'), 'goalwire', 'run', 'turtlesim')


@pytest.fixture(scope='module')
def world() -> dict[str, str]:
    return isolated_env(NETWORK)


@pytest.fixture(scope='module')
def simulator(world: dict[str, str]) -> Iterator[Program]:
    """One simulator for the pages: each test leaves turtle1 there."""
    with Program(*RUN, 'turtlesim_node', '--no-open', env=world) as program:
        program.expect(r'\[turtlesim\]: Starting turtlesim with node name /turtlesim')
        program.expect(
            r'Spawning turtle \[turtle1\] at x=\[5\.544445\], y=\[5\.544445\], theta=\[0\.000000\]'
        )
        yield program


@pytest.fixture
def ros2(world: dict[str, str], simulator: Program) -> CommandLine:
    return CommandLine(world)


def test_executables_of_the_first_page(ros2: CommandLine) -> None:
    assert ros2.ok('pkg', 'executables', 'turtlesim').splitlines() == [
        'turtlesim draw_square',
        'turtlesim mimic',
        'turtlesim turtle_teleop_key',
        'turtlesim turtlesim_node',
    ]


def test_the_page_on_nodes(ros2: CommandLine) -> None:
    assert ros2.ok('node', 'list') == '/turtlesim\n'
    info = ros2.ok('node', 'info', '/turtlesim')
    for line in (
        '/turtle1/cmd_vel: geometry_msgs/msg/Twist',
        '/turtle1/color_sensor: turtlesim/msg/Color',
        '/turtle1/pose: turtlesim/msg/Pose',
        '/turtle1/teleport_absolute: turtlesim/srv/TeleportAbsolute',
        '/turtle1/rotate_absolute: turtlesim/action/RotateAbsolute',
    ):
        assert f'    {line}\n' in info


def test_the_page_on_topics(ros2: CommandLine) -> None:
    assert '/turtle1/cmd_vel [geometry_msgs/msg/Twist]' in ros2.ok('topic', 'list', '-t')
    command = '{linear: {x: 2.0, y: 0.0, z: 0.0}, angular: {x: 0.0, y: 0.0, z: 1.8}}'
    ros2.ok('topic', 'pub', '--once', '-w', '1', '/turtle1/cmd_vel', 'geometry_msgs/msg/Twist', command)
    pose = ros2.ok('topic', 'echo', '/turtle1/pose', '--once')
    assert re.search(r'^x: \d+\.\d+$', pose, re.MULTILINE)
    assert '/turtle1/pose' in ros2.ok('topic', 'find', 'turtlesim/msg/Pose')


def test_the_page_on_services(ros2: CommandLine, simulator: Program) -> None:
    assert ros2.ok('service', 'type', '/clear') == 'std_srvs/srv/Empty\n'
    assert ros2.ok('interface', 'show', 'turtlesim/srv/Spawn').count('float32') == 3
    ros2.ok('service', 'call', '/clear', 'std_srvs/srv/Empty')
    simulator.expect('Clearing turtlesim.')
    request = "{x: 2, y: 2, theta: 0.2, name: ''}"
    assert "name='turtle2'" in ros2.ok('service', 'call', '/spawn', 'turtlesim/srv/Spawn', request)
    simulator.expect(r'Spawning turtle \[turtle2\] at x=\[2\.000000\], y=\[2\.000000\], theta=\[0\.200000\]')
    assert '/turtle2/cmd_vel' in ros2.ok('topic', 'list')
    assert "name=''" in ros2.ok('service', 'call', '/spawn', 'turtlesim/srv/Spawn', "{name: 'turtle2'}")
    simulator.expect(r'A turtle named \[turtle2\] already exists')
    ros2.ok('service', 'call', '/kill', 'turtlesim/srv/Kill', "{name: 'turtle2'}")
    assert '/turtle2/cmd_vel' not in ros2.ok('topic', 'list')


def test_the_page_on_parameters(ros2: CommandLine) -> None:
    listed = ros2.ok('param', 'list')
    assert '/turtlesim:\n  background_b\n  background_g\n  background_r\n  holonomic\n' in listed
    assert ros2.ok('param', 'get', '/turtlesim', 'background_g') == 'Integer value is: 86\n'
    assert ros2.ok('param', 'set', '/turtlesim', 'background_r', '150') == 'Set parameter successful\n'
    assert 'background_r: 150' in ros2.ok('param', 'dump', '/turtlesim')
    assert ros2('param', 'set', '/turtlesim', 'background_r', '256').code != 0


def test_the_page_on_actions(ros2: CommandLine) -> None:
    assert ros2.ok('action', 'list', '-t') == '/turtle1/rotate_absolute [turtlesim/action/RotateAbsolute]\n'
    kind = 'turtlesim/action/RotateAbsolute'
    # Another page has turned the turtle, on a busy machine perhaps to this goal: no feedback would be sent.
    ros2.ok('service', 'call', '/reset', 'std_srvs/srv/Empty')
    sent = ros2.ok('action', 'send_goal', '/turtle1/rotate_absolute', kind, '{theta: 1.57}', '--feedback')
    assert 'Goal finished with status: SUCCEEDED' in sent
    assert 'Feedback:\n    remaining: ' in sent


LATER = """
import rclpy
from rclpy.action import ActionClient
from turtlesim.action import RotateAbsolute

with rclpy.init():
    node = rclpy.create_node('later')
    client = ActionClient(node, RotateAbsolute, '/turtle1/rotate_absolute')
    client.wait_for_server()
    print('ready')
    input()
    sent = client.send_goal_async(RotateAbsolute.Goal(theta=0.0))
    rclpy.spin_until_future_complete(node, sent)
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result)
    print('status', result.result().status)
"""


def test_a_goal_that_comes_later_ends_the_first(ros2: CommandLine, simulator: Program) -> None:
    """The later one is ready before the first is sent: three seconds later the first would have succeeded."""
    kind, name = 'turtlesim/action/RotateAbsolute', '/turtle1/rotate_absolute'
    ros2.ok('service', 'call', '/turtle1/teleport_absolute', 'turtlesim/srv/TeleportAbsolute', '{x: 5, y: 5}')
    command = ('action', 'send_goal', name, kind, '{theta: -3.1}')
    with Program(LATER, env=ros2.env) as later:
        later.expect('ready')
        with Program(Path('-m'), 'goalwire', *command, env=ros2.env) as first:
            first.expect('Goal accepted')
            later.write_line('')
            first.expect('Goal finished with status: ABORTED')
        assert later.succeed().endswith('status 4')
    simulator.expect('Aborting previous goal')


def test_what_is_not_a_number_moves_nothing(ros2: CommandLine, simulator: Program) -> None:
    nowhere = '{x: .nan, y: 1.0}'
    ros2.ok('service', 'call', '/turtle1/teleport_absolute', 'turtlesim/srv/TeleportAbsolute', nowhere)
    simulator.expect('A turtle cannot be moved: the target is not a finite number')
    assert 'nan' not in ros2.ok('topic', 'echo', '/turtle1/pose', '--once')


def test_a_turtle_whose_name_no_topic_can_have_is_refused(ros2: CommandLine, simulator: Program) -> None:
    said = ros2.ok('service', 'call', '/spawn', 'turtlesim/srv/Spawn', "{x: 1, y: 1, name: 'my turtle'}")
    assert "name=''" in said
    simulator.expect(r'A turtle cannot be named \[my turtle\]')
    assert 'my' not in ros2.ok('topic', 'list')


def test_keys_drive_the_turtle(ros2: CommandLine, world: dict[str, str]) -> None:
    ros2.ok('service', 'call', '/reset', 'std_srvs/srv/Empty')
    far = ('topic', 'echo', '/turtle1/pose', '--once', '--filter', 'm.x > 5.6')
    with (
        Program(Path('-m'), 'goalwire', *far, env=world) as echo,
        screen(world, 'run', 'turtlesim', 'turtle_teleop_key') as terminal,
    ):
        terminal.expect('to quit.')
        for _ in range(30):  # keys that are pressed before the two have met move nothing
            terminal.press(UP)
            with suppress(AssertionError):
                echo.succeed(timeout=1.0)
                break
        assert 'x: ' in echo.output
        terminal.press(b'q')
        assert terminal.wait() == 0


def test_keys_need_a_terminal(run: Run) -> None:
    program = run('turtlesim', 'turtle_teleop_key')
    assert program.wait() == 1
    assert program.output == 'turtle_teleop_key: it reads keys, and its input is not a terminal'


def test_the_page_is_for_its_own_machine(simulator: Program) -> None:
    url = page_of(simulator)
    with urllib.request.urlopen(url) as page:
        assert b'<title>TurtleSim</title>' in page.read()
    stranger = urllib.request.Request(url, headers={'Host': 'evil.example:80'})
    with pytest.raises(urllib.error.HTTPError, match='403'):
        urllib.request.urlopen(stranger)


def page_of(simulator: Program) -> str:
    match = re.search(r'the turtles are at (http://127\.0\.0\.1:\d+/)', simulator.output)
    assert match is not None
    return match[1]


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize('sides', [2, pytest.param(4, marks=pytest.mark.long)])
def test_a_square_is_drawn_in_the_browser(run: Run, isolated: dict[str, str], sides: int) -> None:
    simulator = run('turtlesim', 'turtlesim_node', '--no-open')
    simulator.expect('Spawning turtle')
    with chromium() as browser:
        page = browser.new_page(viewport={'width': 560, 'height': 600})
        page.goto(page_of(simulator))
        square = run('turtlesim', 'draw_square')
        for _ in range(2 * sides):  # the sides, and the turn after each
            square.expect('Reached goal')
        until(page, f'() => Math.cos(JSON.parse(document.body.dataset.turtles)[0][3]) * {sides - 3} > 0.98')
        drawn = page.evaluate(PEN_PIXELS)
        folder = Path(os.environ.get('GOALWIRE_SCREENSHOTS') or ROOT / 'build' / 'screenshots')
        folder.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=folder / ('turtle_square.png' if sides == 4 else 'turtlesim.png'))
        assert drawn > 200 * sides, 'sides of 90 pixels, 3 wide, without their soft edges and the turtle'
        simulator.kill()
        until(page, "() => document.getElementById('state').textContent === 'turtlesim_node has ended'")
