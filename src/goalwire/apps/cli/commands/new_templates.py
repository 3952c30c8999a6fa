"""The files that `goalwire new` writes. Words between @ are filled in."""

from __future__ import annotations

from typing import NamedTuple


class Kind(NamedTuple):
    """What a package begins with."""

    program: str
    """The name of its program and module, behind that of the package."""
    interfaces: str
    """The package of its type."""
    type_name: str
    own_type: str
    """The type with the same fields that a package of interfaces of its own has."""
    definition: str
    """The file of that type, in the package of interfaces, and its text behind a line break."""
    code: str
    test: str


NODE = Kind(
    'node',
    'std_msgs',
    'String',
    'Greeting',
    'msg/Greeting.msg\nstring data\n',
    '''"""Says hello on the topic `greeting`, once a second."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String


class @Class@(Node):
    def __init__(self) -> None:
        super().__init__('@node@')
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
SERVICE = Kind(
    'switch_server',
    'std_srvs',
    'SetBool',
    'Switch',
    'srv/Switch.srv\nbool data\n---\nbool success\nstring message\n',
    '''"""A lamp that the service `switch` turns on and off."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_srvs.srv import SetBool


class @Class@(Node):
    def __init__(self) -> None:
        super().__init__('@node@')
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

from @package@.@program@ import @Class@


def test_it_is_switched_on_and_off(gw_graph):
    gw_graph.start(@Class@)
    assert gw_graph.call(SetBool, 'switch', data=True).message == 'on'
    assert gw_graph.call(SetBool, 'switch', data=False).message == 'off'
""",
)
ACTION = Kind(
    'count_server',
    'example_interfaces',
    'Fibonacci',
    'Count',
    'action/Count.action\nint32 order\n---\nint32[] sequence\n---\nint32[] sequence\n',
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
        super().__init__('@node@')
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

from @package@.@program@ import @Class@


def test_it_counts_and_says_how_far_it_is(gw_graph, gw_clock):
    gw_graph.start(@Class@)
    goal = gw_graph.send_goal(Fibonacci, 'count', order=5)
    assert goal.result == Fibonacci.Result(sequence=[0, 1, 1, 2, 3, 5])
    assert len(goal.feedback) == 4
""",
)
MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>@package@</name>
  <version>0.1.0</version>
  <description>@package@</description>
  <maintainer email="you@example.org">you</maintainer>
  <license>Apache-2.0</license>

  <exec_depend>rclpy</exec_depend>
  <exec_depend>launch_ros</exec_depend>
@depends@
  <test_depend>python3-pytest</test_depend>

  <export>
    <build_type>ament_python</build_type>
  </export>
</package>
"""
SETUP = """\
# What colcon reads, and pip and uv as well: the programs, and what is installed beside them.
from glob import glob

from setuptools import find_packages, setup

setup(
    name='@package@',
    version='0.1.0',
    description='@package@',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/@package@']),
        ('share/@package@', ['package.xml']),
        ('share/@package@/launch', glob('launch/*')),
        ('share/@package@/config', glob('config/*')),
    ],
    entry_points={
        'console_scripts': [
@scripts@
        ],
    },
)
"""
PROJECT = """\
# The programs need rclpy: of ROS 2, or of goalwire. It is not named as a dependency, so that this package can
# be installed beside both, and without a package index that has goalwire. See README.md.
[build-system]
requires = ["setuptools>=64"]
build-backend = "setuptools.build_meta"

[project]
name = "@package@"
dynamic = ["version", "description", "entry-points", "scripts"]  # in setup.py, for colcon

[project.optional-dependencies]
test = ["pytest>=8"]

[tool.pytest.ini_options]
pythonpath = ["."]
"""
SCRIPTS = """\
[develop]
script_dir=$base/lib/@package@
[install]
install_scripts=$base/lib/@package@
"""
LAUNCH = """\
from launch import LaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    parameters = PathJoinSubstitution([FindPackageShare('@package@'), 'config', 'parameters.yaml'])
    return LaunchDescription(
        [
@nodes@
        ]
    )
"""
LAUNCHED = (
    "            Node(package='@package@', executable='@script@', parameters=[parameters], output='screen'),"
)
PARAMETERS = """\
/**:
  ros__parameters:
    name: world
"""
README = """\
# @package@

Programs: @programs@. One launch file starts them all.

They need rclpy. With goalwire, in an environment of its own, from the folder above this one:

```sh
pip install goalwire    # if the package index does not have it: pip install -e path/to/its/checkout
@install@
python -m pytest @package@
ros2 launch @package@ @package@.launch.py
```

With ROS 2: put @folders@ into the `src` folder of a workspace and run `colcon build` there. The tests need
goalwire.
"""
INTERFACES_MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>@package@_interfaces</name>
  <version>0.1.0</version>
  <description>The interfaces of @package@</description>
  <maintainer email="you@example.org">you</maintainer>
  <license>Apache-2.0</license>

  <buildtool_depend>ament_cmake</buildtool_depend>
  <build_depend>rosidl_default_generators</build_depend>
  <depend>action_msgs</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>

  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""
INTERFACES_CMAKE = """\
# For colcon, under ROS 2. goalwire reads the definitions as they are.
cmake_minimum_required(VERSION 3.16)
project(@package@_interfaces)

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)

rosidl_generate_interfaces(${PROJECT_NAME}
@definitions@
)

ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""
INTERFACES_PROJECT = """\
# For pip, under goalwire.
[build-system]
requires = ["setuptools>=64"]
build-backend = "setuptools.build_meta"

[project]
name = "@package@_interfaces"
version = "0.1.0"
description = "The interfaces of @package@"

[project.entry-points."goalwire.interfaces"]
@package@_interfaces = "@package@_interfaces"

[tool.setuptools]
packages = ["@package@_interfaces"]
package-dir = { "@package@_interfaces" = "." }

[tool.setuptools.package-data]
"*" = ["package.xml", "msg/*.msg", "srv/*.srv", "action/*.action"]
"""
