"""goalwire check: what is wrong with files, before anything runs."""

from __future__ import annotations

import json
from pathlib import Path

from helpers.command_line import CommandLine, Ended
from launching.conftest import ROBOT


def check(ros2: CommandLine, *arguments: str) -> Ended:
    return ros2('check', *arguments, program='goalwire')


def test_files_without_mistakes(ros2: CommandLine) -> None:
    ended = check(ros2, str(ROBOT))
    assert (ended.code, ended.err) == (0, '')
    assert ended.out == '17 files checked: no mistakes\n'


def test_mistakes_of_launch_files(ros2: CommandLine, tmp_path: Path) -> None:
    python = tmp_path / 'a.launch.py'
    python.write_text(
        'from launch import LaunchDescription\n'
        'from launch.actions import *\n'
        'from launch.event_handlers import OnShutdown\n'
        'from launch_ros.actions import Node\n'
        'from launch.substitutions import LaunchConfiguration\n'
        'def generate_launch_description():\n'
        '    return LaunchDescription([\n'
        "        DeclareLaunchArgument('program', default_value='bose'),\n"
        "        Node(package='demo_robot', executable=LaunchConfiguration('program')),\n"
        "        Node(package='demo_robot', executable='base', parameters=['/no/such.yaml']),\n"
        "        Node(package='demo_robot', executable=LaunchConfiguration('given_later')),\n"
        "        IncludeLaunchDescription('/no/such.launch.xml'),\n"
        '        RegisterEventHandler(OnShutdown(on_shutdown=[\n'
        "            Node(package='demo_robott', executable='base')])),\n"
        '    ])\n'
    )
    xml = tmp_path / 'b.launch.xml'
    xml.write_text('<launch>\n  <include file="$(dirname)/c.launch.yaml"/>\n</launch>\n')
    yaml = tmp_path / 'c.launch.yaml'
    yaml.write_text('launch:\n- node: {pkg: demo_robot, exec: base}\n- nod: {}\n')
    ended = check(ros2, str(tmp_path))
    assert ended.code == 1
    lines = ended.out.splitlines()
    assert lines[-1] == '3 files checked: 5 mistakes'
    assert [line.split(': ')[0] for line in lines[:-1]] == [
        *(f'{python}:{line}' for line in (9, 10, 12, 14)),
        f'{yaml}:3',
    ]
    assert 'did you mean base?' in lines[0]
    assert 'the parameter file /no/such.yaml does not exist' in lines[1]
    first = json.loads(check(ros2, '--json', str(python)).lines[0])
    assert first == {'problem': lines[0]}


def test_mistakes_of_parameter_files(ros2: CommandLine, tmp_path: Path) -> None:
    """A key with one underscore is the most common one: the node would start without its parameters."""
    (tmp_path / 'one.yaml').write_text('base:\n  ros_parameters:\n    speed: 1.0\n')
    (tmp_path / 'two.yaml').write_text('base:\n  ros__parameters:\n    speed: [1.0\n')
    file = tmp_path / 'a.launch.xml'
    file.write_text(
        '<launch>\n  <node pkg="demo_robot" exec="base">\n    <param from="$(dirname)/one.yaml"/>\n'
        '    <param from="$(dirname)/two.yaml"/>\n  </node>\n</launch>\n'
    )
    first, second, last = check(ros2, str(file)).out.splitlines()
    assert first == (
        f"{tmp_path}/one.yaml:2: 'ros_parameters' is not a key of a parameter file; "
        'did you mean ros__parameters?'
    )
    assert second.startswith(f'{tmp_path}/two.yaml:4: ')
    assert last == '1 file checked: 2 mistakes'


def test_mistakes_of_interface_files(ros2: CommandLine, tmp_path: Path) -> None:
    package = tmp_path / 'my_msgs'
    for kind in ('msg', 'srv', 'action'):
        (package / kind).mkdir(parents=True)
    (package / 'package.xml').write_text('<package><name>my_msgs</name></package>')
    (package / 'msg' / 'Good.msg').write_text('std_msgs/Header header\nOther other\n')
    (package / 'msg' / 'Other.msg').write_text('int32 a\n')
    (package / 'msg' / 'Bad.msg').write_text('int32 a\nint33 b\n')
    (package / 'srv' / 'Ask.srv').write_text('int32 a\n---\nno_such_msgs/Thing thing\n')
    (package / 'action' / 'Go.action').write_text('int32 a\n---\n')
    ended = check(ros2, str(package))
    assert ended.code == 1
    lines = ended.out.splitlines()
    assert [line.split(' ')[0].rpartition('my_msgs')[2] for line in lines[:-1]] == [
        '/action/Go.action:2:1:',
        '/msg/Bad.msg:2:1:',
        '/srv/Ask.srv:3:',
    ]
    assert "no package 'no_such_msgs' was found" in lines[2]
    assert lines[-1] == '5 files checked: 3 mistakes'


def test_nothing_to_check(ros2: CommandLine, tmp_path: Path) -> None:
    ended = check(ros2, str(tmp_path))
    assert (ended.code, ended.out) == (3, '')
    assert 'no interface files and no launch files in' in ended.err
    assert 'there is no file or folder' in check(ros2, str(tmp_path / 'x')).err
