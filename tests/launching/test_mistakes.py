"""Mistakes in launch files and on the command line: one line with file and line, no traceback."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from launching.conftest import Launch

from goalwire.errors import LaunchError
from goalwire.launching.commands import show_arguments, show_description
from goalwire.launching.introspection import LaunchIntrospector
from goalwire.launching.sources import get_launch_description_from_any_launch_file

HEAD = """\
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import IfCondition
from launch.substitutions import *
from launch_ros.actions import *

"""
LINE_SEVEN = {
    'undefined = nothing': "NameError: name 'nothing' is not defined",
    'x = (': "SyntaxError: '(' was never closed",
    'import no_such_module': "ModuleNotFoundError: No module named 'no_such_module'",
    'class A: pass; A.b': None,
}
ACTIONS = {
    "Node(package='demo_robott', executable='base')": "'demo_robott' not found; did you mean demo_robot?",
    "Node(package='demo_robot', executable='bose')": 'did you mean base?',
    "Node(package='demo_robot', executable='base', name='a b')": 'node name',
    "Node(package='demo_robot', executable='base', nane='x')": 'nane',
    "Node(package='demo_robot', executable='base', parameters=[{'a': [1, 'x']}])": "parameter 'a'",
    "LogInfo(msg=LaunchConfiguration('sped'))": "launch configuration 'sped' does not exist",
    "LogInfo(msg='x', condition=IfCondition('maybe'))": "one of true, false, 1 or 0, but got 'maybe'",
    "LogInfo(msg=PythonExpression('1 +'))": "cannot evaluate '1 +'",
    'LogInfo(msg=PythonExpression("open(\'/etc/passwd\')"))': "name 'open' is not defined",
    "LogInfo(msg=PythonExpression('().__class__'))": 'may not use __class__',
    "LogInfo(msg=Command('false'))": "the command 'false' failed with exit code 1",
    "LogInfo(msg=EnvironmentVariable('NOT_THERE'))": "environment variable 'NOT_THERE' does not exist",
    "IncludeLaunchDescription('/no/such.launch.py')": '/no/such.launch.py: No such file or directory',
    "DeclareLaunchArgument('needed')": "argument 'needed' was not provided: pass needed:=VALUE",
    "DeclareLaunchArgument('a', default_value='x', choices=['y'])": (
        "default_value 'x' of argument 'a' is not in provided choices ['y']"
    ),
    "ExecuteProcess(cmd=['x'], output='screan')": "output 'screan' is unknown: use one of screen, log",
    "TimerAction(period='soon', actions=[])": "a timer's period is a number of seconds, not 'soon'",
    'OpaqueFunction(function=lambda context: 1 / 0)': 'ZeroDivisionError: division by zero',
    "ExecuteProcess(cmd=['/no/such/program'])": "cannot start '/no/such/program'",
}
XML = {
    '<nod pkg="a" exec="b"/>': 'unknown tag `nod`; did you mean node',
    '<node pkg="a"/>': "<node> needs the attribute 'exec'",
    '<node pkg="a" exec="b" nmae="c"/>': "`node` does not take the attribute 'nmae'; did you mean name?",
    '<node pkg="a" exec="b"><parm name="c" value="d"/></node>': "does not take the tag 'parm' in it",
    '<log message="$(vra x)"/>': 'unknown substitution `vra`; did you mean var',
    '<log message="$(var x"/>': 'no ) ends $(var x',
    '<log message="a">': 'no valid XML: mismatched tag',
    '<timer period="soon"/>': "a timer's period is a number of seconds, not 'soon'",
    '<log message="$(eval nothing)"/>': "name 'nothing' is not defined",
    '<param from="x"/>': 'unknown tag `param`',
    '<node pkg="a" exec="b"><param name="speed" value="fast" type="float"/></node>': (
        "parameter 'speed': 'fast' is not of the type float; give a value such as 1.5"
    ),
}
YAML = {
    '- nod: {pkg: a, exec: b}': 'unknown tag `nod`; did you mean node',
    '- node: {pkg: a}': "<node> needs the attribute 'exec'",
    '- {log: {message: a}': 'no valid YAML',
    '- log:': "<log> needs the attribute 'message'",
    '- log: hello': "'log' needs attributes or a list",
    '- [a, b]': 'expected one tag',
}


def complaint(ros2: CommandLine, file: Path, *arguments: str) -> str:
    """The one error line of a launch that fails."""
    ended = ros2('launch', str(file), *arguments)
    assert ended.code == 1, ended
    assert 'Traceback' not in ended.out, ended.out
    lines = [line for line in (*ended.out.splitlines(), *ended.err.splitlines()) if str(file) in line]
    assert len(lines) == 1, ended
    return lines[0]


@pytest.mark.parametrize('line', [line for line, told in LINE_SEVEN.items() if told])
def test_a_python_file_with_an_error_in_line_7(line: str, ros2: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / 'broken.launch.py'
    file.write_text(f'{HEAD}{line}\n\ndef generate_launch_description():\n    return LaunchDescription()\n')
    assert complaint(ros2, file) == f'[ERROR] [launch]: {file}:7: {LINE_SEVEN[line]}'


@pytest.mark.parametrize('action', list(ACTIONS))
def test_an_action_in_line_9_that_cannot_be_carried_out(
    action: str, ros2: CommandLine, tmp_path: Path
) -> None:
    file = tmp_path / 'wrong.launch.py'
    body = f'def generate_launch_description():\n    return LaunchDescription([\n        {action},\n    ])\n'
    file.write_text(HEAD + body)
    line = complaint(ros2, file)
    assert f'{file}:9: ' in line
    assert ACTIONS[action] in line


@pytest.mark.parametrize('tag', list(XML))
def test_an_xml_file_with_an_error_in_line_7(tag: str, ros2: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / 'wrong.launch.xml'
    file.write_text('<launch>\n' + '  <!-- -->\n' * 5 + f'  {tag}\n</launch>\n')
    line = complaint(ros2, file)
    assert f'{file}:{8 if "mismatched" in XML[tag] else 7}: ' in line
    assert XML[tag] in line


@pytest.mark.parametrize('tag', list(YAML))
def test_a_yaml_file_with_an_error_in_line_7(tag: str, ros2: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / 'wrong.launch.yaml'
    file.write_text('launch:\n' + '# nothing\n' * 5 + f'{tag}\n')
    line = complaint(ros2, file)
    assert f'{file}:{8 if "valid YAML" in YAML[tag] else 7}: ' in line
    assert YAML[tag] in line


def test_an_error_in_an_included_file_is_told_with_its_own_line(ros2: CommandLine, tmp_path: Path) -> None:
    inner = tmp_path / 'inner.launch.xml'
    inner.write_text('<launch>\n  <log message="$(var missing)"/>\n</launch>\n')
    outer = tmp_path / 'outer.launch.yaml'
    outer.write_text('launch:\n- include: {file: $(dirname)/inner.launch.xml}\n')
    ended = ros2('launch', str(outer))
    assert f"[ERROR] [launch]: {inner}:2: launch configuration 'missing' does not exist" in ended.out


def test_an_error_ends_what_runs_already(launch: Launch, tmp_path: Path) -> None:
    file = tmp_path / 'late.launch.xml'
    file.write_text(
        '<launch>\n<node pkg="demo_robot" exec="base"/>\n<timer period="1.0">\n<log message="$(var no)"/>\n'
        '</timer>\n</launch>\n'
    )
    with launch(file) as late:
        late.started(1)
        output = late.ended(code=1)
    assert f'{file}:4: ' in output
    assert (
        'base cleans up' in (Path(output.partition('below ')[2].splitlines()[0]) / 'launch.log').read_text()
    )


def test_the_command_line_is_checked(ros2: CommandLine, tmp_path: Path) -> None:
    assert ros2.fails('launch', 'demo_robot', 'brinup.launch.py', code=3).endswith(
        'did you mean bringup.launch.py?'
    )
    assert ros2.fails('launch', 'demo_robott', 'bringup.launch.py', code=3) == (
        "ros2 launch: package 'demo_robott' not found; did you mean demo_robot?"
    )
    assert 'there is no launch file' in ros2.fails('launch', str(tmp_path / 'x.launch.py'), code=3)
    assert ros2.fails('launch', 'demo_robot', 'fleet.launch.py', 'count=3', code=2) == (
        "ros2 launch: malformed launch argument 'count=3', expected format '<name>:=<value>'"
    )
    assert "which launch file of the package 'demo_robot'?" in ros2.fails('launch', 'demo_robot', code=3)
    text = tmp_path / 'notes.txt'
    text.write_text('hello')
    ended = ros2('launch', str(text))
    assert ended.code == 1
    assert f'{text} is not a launch file: as XML: ' in ended.out
    assert ended.out.endswith('as Python: it defines no generate_launch_description()\n')


def test_arguments_are_shown(ros2: CommandLine) -> None:
    assert ros2.ok('launch', 'demo_robot', 'navigation.launch.xml', '--show-args').splitlines() == [
        "Arguments (pass arguments as '<name>:=<value>'):",
        '',
        "    'speed':",
        '        Metres per second',
        "        (default: '1.0')",
        '',
        "    'planner':",
        "        no description given. Valid choices are: ['grid', 'lattice']",
        "        (default: 'grid')",
    ]
    documents = ros2.ok('launch', 'demo_robot', 'navigation.launch.xml', '-s', '--json').splitlines()
    assert json.loads(documents[1]) == {
        'name': 'planner',
        'description': "no description given. Valid choices are: ['grid', 'lattice']",
        'default': 'grid',
        'choices': ['grid', 'lattice'],
        'conditional': False,
    }
    assert '--json goes with --show-args' in ros2.fails(
        'launch', 'demo_robot', 'fleet.launch.py', '--json', code=2
    )
    shown = ros2.ok('launch', 'demo_robot', 'bringup.launch.py', '-s')
    names = [line.strip(" ':") for line in shown.splitlines() if line.startswith("    '")]
    assert names == ['namespace', 'use_sim_time', 'use_camera', 'params_file', 'planner']
    shown = ros2.ok('launch', 'demo_robot', 'multi_robot.launch.xml', '-s')
    assert "    'base':" in shown
    assert "    'joints':" not in shown, 'the include gives it'
    assert 'No arguments.' in ros2.ok('launch', 'demo_robot', 'sequence.launch.py', '-s')


def test_the_description_is_printed(ros2: CommandLine) -> None:
    tree = ros2.ok('launch', 'demo_robot', 'bringup.launch.py', '--print').splitlines()
    assert tree[0] == 'LaunchDescription'
    assert "├── DeclareLaunchArgument('namespace')" in tree
    assert any("Node(package='demo_robot', executable='lidar'" in line for line in tree)
    assert any('if UnlessCondition(LaunchConfig(' in line for line in tree)
    assert json.loads(ros2.ok('launch', 'demo_robot', 'bringup.launch.py', '-p', '--json'))['tree'] == tree


@pytest.mark.parametrize('ending', ['py', 'xml'])
def test_a_file_that_does_not_load_is_told_when_shown(ending: str, ros2: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / f'broken.launch.{ending}'
    file.write_text('\nimport no_such_module\n' if ending == 'py' else '\n<launch><x/></launch>')
    for flag in ('-s', '-p'):
        assert f'{file}:2: ' in ros2.fails('launch', str(file), flag, code=1)


def test_an_error_before_anything_runs_starts_nothing(ros2: CommandLine, tmp_path: Path) -> None:
    """Nodes above the mistake in the file would only be interrupted while their Python starts."""
    file = tmp_path / 'early.launch.xml'
    file.write_text(
        '<launch>\n'
        + f'<executable cmd="{sys.executable} -c 0"/>\n' * 3
        + '<log message="$(var no)"/>\n</launch>\n'
    )
    lines = ros2('launch', str(file)).out.splitlines()
    assert lines[-1].startswith(f'[ERROR] [launch]: {file}:5: launch configuration')
    assert [line for line in lines if 'process' in line] == []


def test_an_error_stands_last_and_children_that_still_start_end_without_tracebacks(
    ros2: CommandLine, tmp_path: Path
) -> None:
    """The child raises SIGINT itself, as it would get it in the middle of its imports."""
    (tmp_path / 'slow_import.py').write_text(
        'import os, signal, sys\nopen(sys.argv[1], "w").close()\nsignal.pause()\nprint("never")\n'
    )
    file = tmp_path / 'late.launch.py'
    file.write_text(
        'import asyncio, os, sys\n'
        'from launch import LaunchDescription\n'
        'from launch.actions import ExecuteProcess, OpaqueCoroutine\n'
        f'mark, program = {str(tmp_path / "mark")!r}, {str(tmp_path / "slow_import.py")!r}\n'
        'async def fail():\n'
        '    while not os.path.exists(mark):\n'
        '        await asyncio.sleep(0.01)\n'
        '    raise RuntimeError("no map")\n'
        'def generate_launch_description():\n'
        '    return LaunchDescription([\n'
        '        ExecuteProcess(cmd=[sys.executable, program, mark], name="slow", output="screen"),\n'
        '        OpaqueCoroutine(coroutine=fail, ignore_context=True),\n'
        '    ])\n'
    )
    ended = ros2('launch', str(file))
    assert ended.code == 1
    lines = ended.out.splitlines()
    assert lines[-1] == f'[ERROR] [launch]: {file}:8: RuntimeError: no map'
    assert any('[slow-1]: process was interrupted while it was still starting' in line for line in lines)
    assert 'Traceback' not in ended.out
    assert len(lines) <= 7


@pytest.mark.parametrize('ending', ['xml', 'yaml'])
def test_an_argument_that_no_file_has_is_told(ending: str, ros2: CommandLine, tmp_path: Path) -> None:
    """Names that an included file uses count, those of the launch itself, too."""
    (tmp_path / 'inner.launch.yaml').write_text('launch:\n- log: {message: $(var colour)}\n')
    file = tmp_path / f'outer.launch.{ending}'
    if ending == 'xml':
        file.write_text(
            '<launch>\n  <arg name="speed" default="1"/>\n  <include file="$(dirname)/inner.launch.yaml"/>\n'
            '</launch>\n'
        )
    else:
        file.write_text(
            'launch:\n- arg: {name: speed, default: "1"}\n- include: {file: $(dirname)/inner.launch.yaml}\n'
        )
    ended = ros2('launch', str(file), 'spede:=2', 'colour:=red', 'sigterm_timeout:=3', 'lamp:=4')
    assert ended.code == 0
    assert [line for line in ended.out.splitlines() if 'WARN' in line] == [
        "[WARNING] [launch]: the launch file has no argument 'spede'; did you mean speed?",
        "[WARNING] [launch]: the launch file has no argument 'lamp'; it takes speed",
    ]


def test_arguments_are_not_judged_where_a_python_file_may_use_them(ros2: CommandLine, tmp_path: Path) -> None:
    (tmp_path / 'inner.launch.py').write_text(
        'from launch import LaunchDescription\n\n\ndef generate_launch_description():\n'
        '    return LaunchDescription([])\n'
    )
    file = tmp_path / 'outer.launch.xml'
    file.write_text('<launch>\n  <include file="$(dirname)/inner.launch.py"/>\n</launch>\n')
    ended = ros2('launch', str(file), 'lamp:=4')
    assert ended.code == 0
    assert 'WARN' not in ended.out


@pytest.mark.parametrize(
    ('line', 'told'),
    [
        ("Node(package='a', executable='b', nme='c')", "Node does not take 'nme'; did you mean name?"),
        (
            "Node(package='a', executable='b', paramters=[])",
            "Node does not take 'paramters'; did you mean parameters?",
        ),
        (
            "ExecuteProcess(cmd=['a'], ouput='screen')",
            "ExecuteProcess does not take 'ouput'; did you mean output?",
        ),
        ('GroupAction([], xyz=1)', "GroupAction does not take 'xyz'"),
    ],
)
def test_a_misspelt_keyword_is_told_with_a_near_name(
    line: str, told: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / 'misspelt.launch.py'
    file.write_text(
        'from launch import LaunchDescription\nfrom launch.actions import *\n'
        'from launch_ros.actions import Node\n'
        f'def generate_launch_description():\n    return LaunchDescription([{line}])\n'
    )
    with pytest.raises(LaunchError) as error:
        get_launch_description_from_any_launch_file(str(file))
    assert str(error.value) == f'{file}:5: {told}'


DOT_LAUNCH = {
    'XML': '<launch>\n  <log message="hello"/>\n</launch>\n',
    'YAML': 'launch:\n- log: {message: hello}\n',
    'Python': (
        'from launch import LaunchDescription\nfrom launch.actions import LogInfo\n'
        "def generate_launch_description():\n    return LaunchDescription([LogInfo(msg='hello')])\n"
    ),
}


@pytest.mark.parametrize('notation', list(DOT_LAUNCH))
def test_a_file_whose_ending_tells_nothing_is_read_by_its_content(notation: str, tmp_path: Path) -> None:
    file = tmp_path / 'robot.launch'
    file.write_text(DOT_LAUNCH[notation])
    description = get_launch_description_from_any_launch_file(str(file))
    assert LaunchIntrospector().format_launch_description(description).endswith("('hello')")


def test_an_error_in_a_file_with_tags_is_that_of_xml_alone(tmp_path: Path) -> None:
    file = tmp_path / 'robot.launch'
    file.write_text('<launch>\n  <log message="hello">\n</launch>\n')
    with pytest.raises(LaunchError, match=r'robot\.launch:3: no valid XML: mismatched tag'):
        get_launch_description_from_any_launch_file(str(file))


INCLUDES = """<launch>
  <arg name="speed" default="1"/>
  <include file="$(find-pkg-share no_such_package)/a.launch.xml"/>
  <include file="$(dirname)/gone.launch.xml"/>
  <include file="$(dirname)/inner.launch.xml">
    <arg name="colour" value="$(var colour)"/>
    <arg name="size" value="3"/>
  </include>
</launch>
"""


def test_arguments_that_an_include_passes_on_are_shown_and_missing_files_are_told(tmp_path: Path) -> None:
    file = tmp_path / 'outer.launch.xml'
    file.write_text(INCLUDES)
    (tmp_path / 'inner.launch.xml').write_text(
        '<launch>\n  <arg name="colour" default="red"/>\n  <arg name="size" default="1"/>\n</launch>\n'
    )
    shown = show_arguments(str(file)).splitlines()
    assert [line for line in shown if line.endswith(':')][1:3] == ["    'speed':", "    'colour':"]
    assert shown[-3:] == [
        'Passed over, with the arguments in it:',
        (
            f"    {file}:3: package 'no_such_package' not found; source the workspace that has it, "
            'or install it by pip'
        ),
        f'    {file}:4: cannot read the launch file {tmp_path}/gone.launch.xml: No such file or directory',
    ]
    tree = show_description(str(file))
    assert tree.count('└── not there: ') == 2
    assert "DeclareLaunchArgument('colour'" in tree
