"""ros2 interface and component: no wire is needed."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import NETWORK, isolated_env

from goalwire.idl.registry import definition_text

MESSAGE = """# The top.
Inner[2] inner  # two of them
std_msgs/Header header # when
uint8 RED=1 # stays
string name "a # b"

int32 last
"""
SHOWN = """# The top.
Inner[2] inner  # two of them
	float64 x
std_msgs/Header header # when
	builtin_interfaces/Time stamp
		int32 sec
		uint32 nanosec
	string frame_id
uint8 RED=1 # stays
string name "a # b"

int32 last
"""
BARE = """Inner[2] inner
	float64 x
std_msgs/Header header
	builtin_interfaces/Time stamp
		int32 sec
		uint32 nanosec
	string frame_id
uint8 RED=1 # stays
string name "a # b"
int32 last
"""


@pytest.fixture(scope='module')
def world() -> dict[str, str]:
    return isolated_env(NETWORK)


@pytest.fixture
def ros2(world: dict[str, str], tmp_path: Path) -> CommandLine:
    """A command line that knows one package more."""
    folder = tmp_path / 'shop_interfaces' / 'msg'
    folder.mkdir(parents=True)
    (folder / 'Outer.msg').write_text(MESSAGE, encoding='utf-8')
    (folder / 'Inner.msg').write_text('# Inside.\nfloat64 x # a number\n', encoding='utf-8')
    (folder.parent / 'package.xml').write_text(
        '<package format="3"><name>shop_interfaces</name><version>1.0.0</version></package>', encoding='utf-8'
    )
    return CommandLine({**world, 'GOALWIRE_INTERFACE_PATH': str(tmp_path)})


def test_show_is_what_ros_2_prints(ros2: CommandLine) -> None:
    assert ros2.ok('interface', 'show', 'shop_interfaces/msg/Outer') == SHOWN
    assert ros2.ok('interface', 'show', 'shop_interfaces/Outer', '--no-comments') == BARE
    every = ros2.ok('interface', 'show', '-', '--all-comments', stdin='shop_interfaces/msg/Outer\n')
    assert '\t# Inside.\n\tfloat64 x # a number\n' in every
    assert ros2.ok('interface', 'show', 'example_interfaces/action/Fibonacci', '--no-comments') == (
        'int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n'
    )


def test_lists_name_what_there_is(ros2: CommandLine) -> None:
    lines = ros2.ok('interface', 'list').splitlines()
    assert [line for line in lines if not line.startswith(' ')] == ['Messages:', 'Services:', 'Actions:']
    assert '    shop_interfaces/msg/Outer' in lines
    assert ros2.ok('interface', 'list', '-a').splitlines()[0] == 'Actions:'
    assert ros2.ok('interface', 'package', 'shop_interfaces') == (
        'shop_interfaces/msg/Inner\nshop_interfaces/msg/Outer\n'
    )
    packages = ros2.ok('interface', 'packages', '-s').splitlines()
    assert 'std_srvs' in packages
    assert 'shop_interfaces' not in packages


def test_proto_is_yaml_in_quotes(ros2: CommandLine) -> None:
    assert ros2.ok('interface', 'proto', 'shop_interfaces/msg/Inner') == '"x: 0.0\n"\n'
    assert ros2.ok('interface', 'proto', 'std_srvs/srv/SetBool', '--no-quotes') == 'data: false\n\n'


def test_stubs_are_written(ros2: CommandLine, tmp_path: Path) -> None:
    out = ros2.ok('interface', 'stubs', str(tmp_path / 'typings'), 'shop_interfaces')
    assert out.endswith(f'files in {tmp_path / "typings"}, for: shop_interfaces\n')
    assert 'class Outer' in (tmp_path / 'typings' / 'shop_interfaces' / 'msg' / '__init__.pyi').read_text()
    assert 'nowhere' in ros2.fails('interface', 'stubs', str(tmp_path), 'nowhere', code=3)


def test_what_is_not_there_is_told_with_what_is_near(ros2: CommandLine) -> None:
    assert "did you mean 'std_srvs'" in ros2.fails('interface', 'package', 'std_srv', code=3)
    assert 'did you mean' in ros2.fails('interface', 'show', 'std_srvs/srv/SetBol', code=3)
    assert "'x' is not a type" in ros2.fails('interface', 'show', 'x', code=4)


def test_shipped_definitions_are_written_as_ros_2_writes_them() -> None:
    quaternion = definition_text('geometry_msgs/msg/Quaternion').splitlines()
    assert quaternion[-4:] == ['float64 x 0', 'float64 y 0', 'float64 z 0', 'float64 w 1']
    assert 'sensor_msgs/CameraInfo camera_info\n' in definition_text('sensor_msgs/srv/SetCameraInfo')
    assert 'nav_msgs/OccupancyGrid map\n' in definition_text('nav_msgs/srv/SetMap')


def test_components_are_those_of_the_ament_index(world: dict[str, str], tmp_path: Path) -> None:
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'rclcpp_components'
    index.mkdir(parents=True)
    (index / 'demo').write_text(
        'demo::Talker;lib/libtalker.so\ndemo::Listener;lib/lib.so\n', encoding='utf-8'
    )
    ros2 = CommandLine({**world, 'AMENT_PREFIX_PATH': str(tmp_path)})
    assert ros2.ok('component', 'types') == 'demo\n  demo::Talker\n  demo::Listener\n'
    assert ros2.ok('component', 'types', 'demo') == 'demo::Talker\ndemo::Listener\n'
    assert 'has no components' in ros2.fails('component', 'types', 'nothing', code=3)
