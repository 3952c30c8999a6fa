"""ros2 pkg and ros2 run."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable
from helpers.processes import Program

from goalwire.launching.source_programs import interpreter_lines


def test_packages_are_listed(ros2: CommandLine) -> None:
    names = ros2.ok('pkg', 'list').splitlines()
    assert names == sorted(names)
    assert {'demo_robot', 'std_msgs'} <= set(names)
    assert json.loads(ros2.ok('pkg', 'list', '--json')) == names


def test_a_package_has_a_prefix_and_a_share(ros2: CommandLine, prefix: Path) -> None:
    assert ros2.ok('pkg', 'prefix', 'demo_robot') == f'{prefix}\n'
    assert ros2.ok('pkg', 'prefix', '--share', 'demo_robot') == f'{prefix}/share/demo_robot\n'
    assert ros2.fails('pkg', 'prefix', 'demo_robo', code=3) == (
        "ros2 pkg prefix: package 'demo_robo' not found; did you mean demo_robot?"
    )


def test_executables(ros2: CommandLine, prefix: Path) -> None:
    names = ros2.ok('pkg', 'executables', 'demo_robot').splitlines()
    assert {'demo_robot base', 'demo_robot managed'} <= set(names)
    assert f'{prefix}/lib/demo_robot/base' in ros2.ok('pkg', 'executables', 'demo_robot', '--full-path')
    assert 'demo_robot base' in ros2.ok('pkg', 'executables').splitlines()


def test_the_manifest(ros2: CommandLine) -> None:
    assert '<name>demo_robot</name>' in ros2.ok('pkg', 'xml', 'demo_robot')
    assert ros2.ok('pkg', 'xml', 'demo_robot', '-t', 'version') == '1.2.3\n'
    assert "no tag 'nothing'" in ros2.fails('pkg', 'xml', 'demo_robot', '--tag', 'nothing', code=3)


def test_a_package_of_a_source_folder(world: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / 'src' / 'my_bringup'
    (folder / 'launch').mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>my_bringup</name></package>')
    (folder / 'launch' / 'hello.launch.xml').write_text(
        '<launch><log message="from $(find-pkg-share my_bringup)"/></launch>'
    )
    program = Program(executable(), 'launch', 'my_bringup', 'hello.launch.xml', env=world, cwd=tmp_path)
    with program:
        assert f'[INFO] [launch.user]: from {folder}' in program.succeed()


MODULE_FOLDERS = ('my_bringup', 'src/my_bringup')
USING_A_MODULE = """from launch import LaunchDescription
from launch.actions import LogInfo
from my_bringup.greeting import greet

def generate_launch_description():
    return LaunchDescription([LogInfo(msg=greet())])
"""


@pytest.mark.parametrize('place', MODULE_FOLDERS)
def test_a_launch_file_imports_the_module_of_a_source_package(
    place: str, world: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / 'src' / 'my_bringup'
    (folder / place).mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>my_bringup</name></package>')
    (folder / place / '__init__.py').touch()
    (folder / place / 'greeting.py').write_text('def greet():\n    return "from a module"\n')
    file = tmp_path / 'a.launch.py'
    file.write_text(USING_A_MODULE)
    with Program(executable(), 'launch', str(file), env=world, cwd=tmp_path) as program:
        output = program.succeed()
    assert '[INFO] [launch.user]: from a module' in output
    assert f'is taken from {folder}, below the working directory' in output
    assert not (folder / place / '__pycache__').exists()


SETUP_FILES = {
    'setup.py': "setup(entry_points={'console_scripts': ['greet = my_node.main:main']})\n",
    'setup.cfg': '[options.entry_points]\nconsole_scripts =\n    greet = my_node.main:main\n',
    'pyproject.toml': '[project]\nname = "my_node"\n[project.scripts]\ngreet = "my_node.main:main"\n',
}


@pytest.mark.skipif(sys.platform == 'win32', reason='a script with an interpreter line')
@pytest.mark.parametrize('name', list(SETUP_FILES))
@pytest.mark.parametrize('layout', ['', 'src'])
def test_programs_of_a_source_folder(name: str, layout: str, world: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / 'ws' / 'my_node'
    code = folder / layout / 'my_node'
    code.mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>my_node</name></package>')
    (folder / name).write_text(SETUP_FILES[name])
    (code / '__init__.py').touch()
    (code / 'main.py').write_text('import sys\ndef main():\n    print("hello", sys.argv)\n    return 3\n')
    env = {**world, 'XDG_CACHE_HOME': str(tmp_path / 'cache')}
    for _ in range(2):  # made, and found
        with Program(executable(), 'run', 'my_node', 'greet', 'you', env=env, cwd=tmp_path / 'ws') as program:
            assert program.wait() == 3
            told = f'note: the package my_node is taken from {folder}, below the working directory'
            assert program.output == f"{told}\nhello ['greet', 'you']"
    with Program(executable(), 'run', 'my_node', 'gret', env=env, cwd=tmp_path / 'ws') as program:
        assert program.wait() == 3
        assert 'did you mean greet?' in program.output
    (folder / name).write_text('this is [ no such file\n')
    with Program(executable(), 'pkg', 'executables', 'my_node', env=env, cwd=tmp_path / 'ws') as program:
        assert program.succeed() == ''


@pytest.mark.skipif(sys.platform == 'win32', reason='a script with an interpreter line')
@pytest.mark.parametrize('folder', ["it's my robot", 'deep/' * 60], ids=['a space', 'a long path'])
def test_a_program_starts_wherever_its_python_lies(folder: str, tmp_path: Path) -> None:
    python = tmp_path / folder / 'python'
    python.parent.mkdir(parents=True)
    python.symlink_to(sys.executable)
    program = tmp_path / 'program'
    program.write_text(f'{interpreter_lines(str(python))}\nimport sys\nprint(sys.argv[1:])\n')
    program.chmod(0o755)
    assert subprocess.check_output([program, 'a b', '$HOME'], text=True) == "['a b', '$HOME']\n"


@pytest.mark.skipif(sys.platform == 'win32', reason='a script with an interpreter line')
def test_run_becomes_the_program(world: dict[str, str], prefix: Path, ros2: CommandLine) -> None:
    talker = prefix / 'lib' / 'demo_robot' / 'talker'
    first = interpreter_lines(sys.executable)
    talker.write_text(f'{first}\nimport sys, time\nprint(sys.argv[1:], flush=True)\ntime.sleep(100)\n')
    talker.chmod(0o755)
    arguments = ('a', '--flag', '--ros-args', '-r', '__node:=b')
    with Program(executable(), 'run', 'demo_robot', 'talker', *arguments, env=world) as program:
        program.expect(r"^\['a', '--flag', '--ros-args', '-r', '__node:=b'\]$")
        program.send_signal(signal.SIGTERM)
        assert program.wait() == -signal.SIGTERM
    talker.unlink()
    assert ros2('run', '--prefix', 'echo before', 'demo_robot', 'base', 'after').lines == [
        f'before {prefix}/lib/demo_robot/base after'
    ]
    assert ros2.fails('run', 'demo_robot', 'bsae', code=3).endswith('did you mean base?')
    assert 'did you mean demo_robot?' in ros2.fails('run', 'demo_robt', 'base', code=3)


COMPLETIONS = {
    'launch demo_r': ['demo_robot'],
    'launch demo_robot nav': ['navigation.launch.xml', 'navigation.launch.yaml'],
    'launch demo_robot navigation.launch.xml ': ['planner:=', 'speed:='],
    'launch demo_robot bringup.launch.py use': ['use_camera:=', 'use_sim_time:='],
    'run demo_r': ['demo_robot'],
    'run demo_robot st': ['state_publisher', 'stubborn'],
    'pkg prefix demo_r': ['demo_robot'],
    'pkg xml demo_robot ': [],
    'launch nothing_there x': [],
}


@pytest.mark.parametrize('words', list(COMPLETIONS))
def test_the_shell_completes_packages_files_and_arguments(words: str, ros2: CommandLine) -> None:
    assert ros2.ok('_complete', *words.split(' ')).split() == COMPLETIONS[words]
