"""Launch files in the style of public packages: the programs that they name start and do their job."""

from __future__ import annotations

import signal
from pathlib import Path
from shutil import copytree

import pytest
from helpers.command_line import executable
from helpers.isolation import NETWORK
from helpers.processes import Program

PUBLIC = Path(__file__).with_name('public')
JOBS = {
    'add_two_ints.launch.py': [r'Result of add_two_ints: 5|Incoming request'],
    'blackboard.launch.py': [r'Publishing: .Hello World: 1'],
    'bringup.launch.py': [r'- Translation: \[0.000, 0.000, 0.500\]'],
    'buffer.launch.xml': [r'started', r'\[alpha.talker\]: Publishing'],
    'cameras.launch.py': [r'Received image #'],
    'display.launch.xml': [
        r'the sliders are at http|rviz2: goalwire console',
        r'the (sliders are|console is) at http',
    ],
    'fibonacci.launch.py': [r'Result: .*\[0, 1, 1, 2, 3, 5'],
    'include.launch.py': [r'all included', r'I heard: \[Hello World'],
    'minimal_publisher.launch.py': [r'\[robot1.minimal_subscriber\]: I heard: "Hello World'],
    'old_static_frames.launch.xml': [r'- Translation: \[0.000, 0.000, 2.000\]'],
    'respawn.launch.py': [r'spawned', r'Incoming request|Result of add_two_ints'],
    'robot_description.launch.py': [r'- Translation: \[0.000, 0.000, 0.500\]'],
    'static_frames.launch.py': [r'- Translation: \[1.000, 0.000, 0.000\]'],
    'talker_listener.launch.py': [r'I heard: \[Hello World'],
    'talker_listener.launch.xml': [r'I heard: \[Hello World'],
    'throttle.launch.yaml': [r'I heard: \[Hello World'],
    'turtle_background.launch.yaml': [r'Spawning turtle \[turtle1\]'],
    'turtle_mimic.launch.py': [r'Spawning turtle', r'Spawning turtle'],
    'turtle_mimic.launch.xml': [r'Spawning turtle', r'Spawning turtle'],
    'xacro_command.launch.py': [r'- Translation: \[0.000, 0.000, 0.750\]'],
}


FIRST = {'bringup.launch.py', 'throttle.launch.yaml', 'turtle_mimic.launch.xml', 'xacro_command.launch.py'}
"""They run with every suite, the others by `make long`."""


@pytest.fixture
def transport_name() -> str:
    """Processes need a network."""
    return NETWORK


@pytest.mark.slow
@pytest.mark.parametrize(
    'name', [name if name in FIRST else pytest.param(name, marks=pytest.mark.long) for name in sorted(JOBS)]
)
def test_a_launch_file_does_its_job(name: str, isolated: dict[str, str], tmp_path: Path) -> None:
    # A command in a launch file is split at spaces, as in ROS 2, and the checkout's path may have some.
    copytree(PUBLIC, tmp_path / 'public')
    words = ('launch', str(tmp_path / 'public' / name))
    with Program(executable(), *words, env=isolated | {'BROWSER': 'true'}, cwd=tmp_path) as launched:
        for line in JOBS[name]:
            launched.expect(line)
        assert 'Traceback' not in launched.output
        assert 'process has died' not in launched.output
        launched.send_signal(signal.SIGINT)
        assert launched.wait() in {0, 130}


def test_each_file_has_a_job() -> None:
    assert {file.name for file in PUBLIC.iterdir() if '.launch.' in file.name} == set(JOBS)
