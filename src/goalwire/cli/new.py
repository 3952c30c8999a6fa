"""goalwire new: a package that is an ordinary Python project and one of ROS 2 (ament_python) at once."""

from __future__ import annotations

import keyword
import re
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from goalwire.cli.outcome import CommandError, Outcome
from goalwire.cli.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.cli.output import Output

SUMMARY = 'Make a package: a Python project that colcon builds as well'


class _Kind(NamedTuple):
    """What a package begins with."""

    program: str
    """The name of its program and module, behind that of the package."""
    interfaces: str
    """The package of its type."""
    code: str
    test: str


_NODE = _Kind(
    'node',
    'std_msgs',
    '''"""Says hello on the topic `greeting`, once a second."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String


class @Class@(Node):
    def __init__(self) -> None:
        super().__init__('@package@')
        self.declare_parameter('name', 'world')
        self.publisher = self.create_publisher(String, 'greeting', 10)
        self.create_timer(1.0, self.greet)

    def greet(self) -> None:
        self.publisher.publish(String(data=f'hello, {self.get_parameter("name").value}'))


def main() -> None:
    try:
        with rclpy.init():
            rclpy.spin(@Class@())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
''',
    """from std_msgs.msg import String

from @package@.node import @Class@


def test_it_greets_once_a_second(gw_graph, gw_clock):
    greetings = gw_graph.record(String, 'greeting')
    gw_graph.start(@Class@)
    assert greetings.wait_for(2) == [String(data='hello, world')] * 2
    assert 2.0 <= gw_clock.elapsed < 3.0
""",
)
_SERVICE = _Kind(
    'server',
    'std_srvs',
    '''"""A lamp that the service `switch` turns on and off."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_srvs.srv import SetBool


class @Class@(Node):
    def __init__(self) -> None:
        super().__init__('@package@')
        self.create_service(SetBool, 'switch', self.switch)

    def switch(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = True
        response.message = 'on' if request.data else 'off'
        return response


def main() -> None:
    try:
        with rclpy.init():
            rclpy.spin(@Class@())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
''',
    """from std_srvs.srv import SetBool

from @package@.server import @Class@


def test_it_is_switched_on_and_off(gw_graph):
    gw_graph.start(@Class@)
    assert gw_graph.call(SetBool, 'switch', data=True).message == 'on'
    assert gw_graph.call(SetBool, 'switch', data=False).message == 'off'
""",
)
_ACTION = _Kind(
    'server',
    'example_interfaces',
    '''"""The action `count`: Fibonacci's numbers, one each 0.1 s, with feedback; it can be cancelled."""

import asyncio

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class @Class@(Node):
    def __init__(self) -> None:
        super().__init__('@package@')
        self.server = ActionServer(
            self, Fibonacci, 'count', self.count, cancel_callback=lambda goal: CancelResponse.ACCEPT
        )

    async def count(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        numbers = [0, 1]
        while len(numbers) <= goal.request.order:
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=numbers)
            await asyncio.sleep(0.1)
            numbers.append(numbers[-1] + numbers[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)


def main() -> None:
    try:
        with rclpy.init():
            rclpy.spin(@Class@())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
''',
    """from example_interfaces.action import Fibonacci

from @package@.server import @Class@


def test_it_counts_and_says_how_far_it_is(gw_graph, gw_clock):
    gw_graph.start(@Class@)
    goal = gw_graph.send_goal(Fibonacci, 'count', order=5)
    assert goal.result == Fibonacci.Result(sequence=[0, 1, 1, 2, 3, 5])
    assert len(goal.feedback) == 4
""",
)
_MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>@package@</name>
  <version>0.1.0</version>
  <description>@package@</description>
  <maintainer email="you@example.org">you</maintainer>
  <license>Apache-2.0</license>

  <exec_depend>rclpy</exec_depend>
  <exec_depend>@interfaces@</exec_depend>

  <export>
    <build_type>ament_python</build_type>
  </export>
</package>
"""
_SETUP = """\
# What colcon reads, and pip and uv as well: the programs, and what is installed beside them.
from setuptools import find_packages, setup

setup(
    name='@package@',
    version='0.1.0',
    description='@package@',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/@package@']),
        ('share/@package@', ['package.xml']),
    ],
    entry_points={'console_scripts': ['@package@_@program@ = @package@.@program@:main']},
)
"""
_PROJECT = """\
[build-system]
requires = ["setuptools>=64"]
build-backend = "setuptools.build_meta"

[project]
name = "@package@"
dependencies = ["goalwire"]
dynamic = ["version", "description", "scripts"]  # in setup.py, for colcon

[dependency-groups]
dev = ["pytest>=8"]
"""
_SCRIPTS = """\
[develop]
script_dir=$base/lib/@package@
[install]
install_scripts=$base/lib/@package@
"""


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument('package', help='Its name: small letters, digits and underscores, a letter first')
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument('--node', action='store_const', dest='kind', const=_NODE, help='A node with a topic')
    kinds.add_argument('--service', action='store_const', dest='kind', const=_SERVICE, help='A service')
    kinds.add_argument('--action', action='store_const', dest='kind', const=_ACTION, help='An action')
    parser.set_defaults(kind=_NODE)
    parser.add_argument('--destination-directory', default='.', help='Where its folder is made; here without')


def _run(arguments: Namespace, output: Output) -> None:
    package, kind = arguments.package, arguments.kind
    _check_name(arguments.prog, package)
    folder = Path(arguments.destination_directory, package)
    if folder.exists():
        raise CommandError(
            Outcome.FAILED,
            f'{arguments.prog}: there is a {str(folder)!r} already',
            'choose another name, or another place with --destination-directory',
        )
    files = _files(package, kind)
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding='utf-8', newline='\n')
    if output.json:
        output.data({'folder': str(folder), 'files': sorted(files)})
        return
    output.line(f'made {folder}: {", ".join(sorted(files))}')
    output.line(f'next: cd {folder}; python -m pytest; ros2 run {package} {package}_{kind.program}')


def _check_name(prog: str, package: str) -> None:
    """Raise CommandError for what is no name of a ROS 2 package (REP 144) or of a Python one."""
    if re.fullmatch('[a-z][a-z0-9]*(_[a-z0-9]+)*', package) and not keyword.iskeyword(package):
        return
    wanted = '_'.join(re.findall('[a-z0-9]+', re.sub('(?<=[a-z0-9])(?=[A-Z])', '_', package).lower()))
    wanted = wanted.lstrip('0123456789_')
    advice = f'write {wanted!r}' if wanted and not keyword.iskeyword(wanted) else 'as in my_robot'
    raise CommandError(
        Outcome.BAD_VALUE,
        f'{prog}: {package!r} is no name of a package: small letters, digits, single underscores',
        advice,
    )


def _files(package: str, kind: _Kind) -> dict[str, str]:
    """Return the texts of a new package by their paths."""
    words = {
        'package': package,
        'Class': ''.join(map(str.capitalize, package.split('_'))),
        'program': kind.program,
        'interfaces': kind.interfaces,
    }
    texts = {
        'package.xml': _MANIFEST,
        'setup.py': _SETUP,
        'setup.cfg': _SCRIPTS,
        'pyproject.toml': _PROJECT,
        f'resource/{package}': '',
        f'{package}/__init__.py': '',
        f'{package}/{kind.program}.py': kind.code,
        f'test/test_{kind.program}.py': kind.test,
    }
    return {name: re.sub('@(.*?)@', lambda found: words[found[1]], text) for name, text in texts.items()}


NOUN = Noun('new', SUMMARY, (Verb('new', SUMMARY, _run, _arguments),))
