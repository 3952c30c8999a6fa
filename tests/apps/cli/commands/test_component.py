"""ros2 component: containers, and the components in them. One wire: no wire knows components."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import require

CAMERA = """
from rclpy.node import Node


class Camera(Node):
    def __init__(self, **options):
        super().__init__('camera', **options)
        print('sees at', self.declare_parameter('rate', 30).value, 'Hz', flush=True)
"""
CONTAINER = 'import runpy; runpy.run_module("rclpy_components.component_container", run_name="__main__")'


@pytest.fixture(scope='module')
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the source package `eyes`, whose component is Camera."""
    root = tmp_path_factory.mktemp('workspace')
    code = root / 'eyes' / 'eyes'
    code.mkdir(parents=True)
    (code / '__init__.py').touch()
    (code / 'camera.py').write_text(CAMERA)
    (code.parent / 'package.xml').write_text('<package><name>eyes</name></package>')
    (code.parent / 'setup.cfg').write_text(
        '[options.entry_points]\nrclpy_components =\n    eyes::Camera = eyes.camera:Camera\n'
    )
    return root


@pytest.fixture(scope='module')
def box(workspace: Path) -> Iterator[CommandLine]:
    """`ros2` beside the container /lab/box."""
    require('rmw_zenoh_cpp')
    world = {**isolated_env('rmw_zenoh_cpp'), 'XDG_CACHE_HOME': str(workspace / 'cache')}
    ros2 = CommandLine(world, workspace)
    names = ('--ros-args', '-r', '__node:=box', '-r', '__ns:=/lab')
    with Program(CONTAINER, *names, env=world, cwd=workspace):
        found = ros2('service', 'call', '/lab/box/_container/list_nodes', 'composition_interfaces/ListNodes')
        assert found.code == 0  # the call waits for the container
        yield ros2


def test_a_component_is_loaded_listed_and_unloaded(box: CommandLine) -> None:
    assert box.ok('component', 'list') == '/lab/box\n'
    load = ('component', 'load', 'lab/box', 'eyes', 'eyes::Camera')
    loaded = box.ok(*load, '-n', 'left', '--node-namespace', '/head', '-p', 'rate:=10')
    assert loaded == "Loaded component 1 into '/lab/box' container node as '/head/left'\n"
    assert box.ok('param', 'get', '/head/left', 'rate', '--hide-type') == '10\n'
    assert box.ok(*load, '--quiet') == '2  /camera\n'
    assert box.ok('component', 'list') == '/lab/box\n  1  /head/left\n  2  /camera\n'
    assert box.ok('component', 'list', '/lab/box') == '1  /head/left\n2  /camera\n'
    assert box.ok('component', 'list', '--containers-only') == '/lab/box\n'
    unloaded = box.ok('component', 'unload', '/lab/box', '1', '2')
    assert unloaded.splitlines()[1] == "Unloaded component 2 from '/lab/box' container node"
    told = box.fails('component', 'unload', '/lab/box', '2', code=7)
    assert told.startswith("ros2: the container '/lab/box' did not unload the component 2: ")


@pytest.mark.parametrize(
    ('words', 'code', 'told'),
    [
        (['/lab/bx', 'eyes', 'eyes::Camera'], 3, "no container '/lab/bx'; did you mean '/lab/box'?"),
        (['/lab/box', 'eyes', 'eyes::Nose'], 7, "did not load 'eyes::Nose': LookupError: there is no comp"),
        (['/lab/box', 'eyes', 'eyes::Camera', '-p', 'rate=1'], 4, "--parameter 'rate=1' is not a parameter"),
        (
            ['/lab/box', 'eyes', 'eyes::Camera', '-p', 'rate:=fast'],
            7,
            "rate: give a whole number such as 3, not 'fast' (integer)",
        ),
    ],
)
def test_a_component_that_cannot_be_loaded_is_told(
    box: CommandLine, words: list[str], code: int, told: str
) -> None:
    assert told in box.fails('component', 'load', *words, code=code)


def test_components_in_python_are_among_the_types(workspace: Path) -> None:
    ros2 = CommandLine({**isolated_env('rmw_zenoh_cpp'), 'XDG_CACHE_HOME': str(workspace)}, workspace)
    assert ros2('component', 'types', 'eyes').out == 'eyes::Camera\n'
    told = ros2('component', 'standalone', 'eyes', 'eyes::Nose')
    assert told.code == 3
    assert "there is no component 'eyes::Nose' of the package 'eyes' in Python" in told.err


@pytest.mark.skipif(sys.platform == 'win32', reason='there is no Ctrl-C to send')
def test_a_component_runs_in_a_container_of_its_own(box: CommandLine, workspace: Path) -> None:
    words = ('component', 'standalone', 'eyes', 'eyes::Camera', '-c', 'alone')
    with Program(executable(), *words, env=box.env, cwd=workspace) as program:
        program.expect("^Loaded component 1 into '/alone' container node as '/camera'$")
        program.send_signal(signal.SIGINT)
        assert program.wait() == 130
    assert '/alone' not in box.ok('node', 'list', '--all')
