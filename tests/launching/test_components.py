"""Containers of components: those of C++ are missing without a ROS 2, those in Python run."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.command_line import executable
from helpers.processes import Program

Beside = Callable[[str], str]

CPP = """
<launch>
  {container}
  <load_composable_node target="/box">
    <composable_node pkg="camera" plugin="camera::Other" name="other"/>
  </load_composable_node>
  <executable cmd="echo beside it" output="screen"/>
</launch>
"""
CONTAINERS = {
    'a container': """
  <node_container pkg="rclcpp_components" exec="component_container" name="box" namespace="">
    <composable_node pkg="camera" plugin="camera::Driver" name="driver"/>
  </node_container>""",
    'a plain node': '<node pkg="rclcpp_components" exec="component_container" name="box" namespace="/"/>',
}


@pytest.mark.parametrize('kind', list(CONTAINERS))
def test_a_container_in_cpp_is_skipped_with_one_warning(
    kind: str, world: dict[str, str], tmp_path: Path
) -> None:
    file = tmp_path / 'camera.launch.xml'
    file.write_text(CPP.format(container=CONTAINERS[kind]))
    with Program(executable(), 'launch', str(file), env=world, cwd=tmp_path) as program:
        output = program.succeed()
    assert '[echo-1] beside it' in output
    assert output.count('WARN') == 1
    assert 'container /box: skipped' in output
    assert 'launch this part with a sourced ROS 2' in output
    assert 'camera::Other is skipped with its container /box' in output


def test_a_component_has_if_or_unless(world: dict[str, str], tmp_path: Path) -> None:
    file = tmp_path / 'both.launch.xml'
    file.write_text("""<launch>
  <node_container pkg="rclpy_components" exec="component_container" name="box" namespace="">
    <composable_node pkg="camera" plugin="camera::Driver" name="driver" if="true" unless="true"/>
  </node_container>
</launch>""")
    with Program(executable(), 'launch', str(file), env=world, cwd=tmp_path) as program:
        assert program.wait() != 0
        output = program.output
    assert '`if` and `unless` cannot be used together' in output
    assert 'Traceback' not in output


CAMERA = """
from rclpy.node import Node


class Camera(Node):
    def __init__(self, **options):
        super().__init__('camera', **options)
        self.declare_parameter('rate', 10)
        rate = self.get_parameter('rate').value
        self.get_logger().info(f'{self.get_fully_qualified_name()} sees at {rate} Hz')
"""
PYTHON = """
from launch import LaunchDescription
from launch_ros.actions import ComposableNodeContainer, LoadComposableNodes
from launch_ros.descriptions import ComposableNode

from eyes.words import NAME


def generate_launch_description():
    more = LoadComposableNodes(
        target_container='box',
        composable_node_descriptions=[
            ComposableNode(package='eyes', plugin='eyes::Camera', name='right', parameters=[{'rate': 5}])
        ],
    )
    return LaunchDescription(
        [
            ComposableNodeContainer(
                name='box',
                namespace='',
                package='PACKAGE',
                executable='component_container',
                composable_node_descriptions=[
                    ComposableNode(package='eyes', plugin='eyes::Nothing'),
                    ComposableNode(package='eyes', plugin='eyes::Camera', name=NAME, namespace='head'),
                ],
            ),
            more,
        ]
    )
"""


@pytest.mark.slow
@pytest.mark.parametrize('package', ['rclcpp_components', 'rclpy_components'])
def test_components_in_python_run(package: str, world: dict[str, str], tmp_path: Path) -> None:
    """The launch file imports a module of the source package that has the component."""
    code = tmp_path / 'src' / 'eyes' / 'eyes'
    code.mkdir(parents=True)
    (code / '__init__.py').touch()
    (code / 'words.py').write_text("NAME = 'left'\n")
    (code / 'camera.py').write_text(CAMERA)
    (code.parent / 'package.xml').write_text('<package><name>eyes</name></package>')
    (code.parent / 'setup.cfg').write_text(
        '[options.entry_points]\nrclpy_components =\n    eyes::Camera = eyes.camera:Camera\n'
    )
    (tmp_path / 'eyes.launch.py').write_text(PYTHON.replace('PACKAGE', package))
    env = {**world, 'XDG_CACHE_HOME': str(tmp_path / 'cache')}
    with Program(executable(), 'launch', 'eyes.launch.py', env=env, cwd=tmp_path) as program:
        for _ in ('left', 'right'):  # two actions load them, in any order
            program.expect("Loaded node '/.*' in container '/box'")
        program.send_signal(signal.SIGINT)
        assert program.wait() == 130
        output = program.output
    assert '/head/left sees at 10 Hz' in output
    assert '/right sees at 5 Hz' in output
    if package == 'rclcpp_components':
        skipped, ending = (line for line in output.splitlines() if 'WARN' in line)
        assert 'container /box: skipped eyes::Nothing (' in skipped
        assert 'SIGINT' in ending
    else:
        assert "Failed to load node '' of type 'eyes::Nothing' in container '/box': " in output
