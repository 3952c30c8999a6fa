"""ros2 node, param and lifecycle: their forms are ROS 2's."""

from __future__ import annotations

import json
from pathlib import Path

from helpers.command_line import CommandLine, on_dds_too
from helpers.programs import Start

INFO = """/lab/workshop
  Subscribers:
    /lab/orders: std_msgs/msg/String
  Publishers:
    /lab/state: std_msgs/msg/String
    /parameter_events: rcl_interfaces/msg/ParameterEvent
    /rosout: rcl_interfaces/msg/Log
  Service Servers:
    /lab/add: example_interfaces/srv/AddTwoInts
    /lab/slow: std_srvs/srv/Trigger
    /lab/workshop/describe_parameters: rcl_interfaces/srv/DescribeParameters
    /lab/workshop/get_parameter_types: rcl_interfaces/srv/GetParameterTypes
    /lab/workshop/get_parameters: rcl_interfaces/srv/GetParameters
    /lab/workshop/get_type_description: type_description_interfaces/srv/GetTypeDescription
    /lab/workshop/list_parameters: rcl_interfaces/srv/ListParameters
    /lab/workshop/set_parameters: rcl_interfaces/srv/SetParameters
    /lab/workshop/set_parameters_atomically: rcl_interfaces/srv/SetParametersAtomically
  Service Clients:

  Action Servers:
    /lab/fibonacci: example_interfaces/action/Fibonacci
  Action Clients:

"""


@on_dds_too
def test_nodes_are_listed_and_described(ros2: CommandLine) -> None:
    assert ros2.ok('node', 'list') == '/lab/workshop\n'
    assert ros2.ok('node', 'list', '--all', '--count') == '2\n'
    assert ros2.ok('node', 'info', 'lab/workshop') == INFO
    hidden = ros2.ok('node', 'info', '/lab/workshop', '--include-hidden')
    assert '    /lab/fibonacci/_action/cancel_goal: action_msgs/srv/CancelGoal\n' in hidden
    told = ros2.fails('node', 'info', '/lab/wrkshop', code=3)
    assert told == "ros2: there is no node '/lab/wrkshop'; did you mean '/lab/workshop'? see: ros2 node list"


DUMP = """/lab/workshop:
  ros__parameters:
    arm:
      names:
      - left
      - right
    fixed: 'yes'
    gears: 3
    speed: 1.5
    start_type_description_service: true
    use_sim_time: false

"""
DESCRIBED = """Parameter name: gears
  Type: integer
  Constraints:
    Min value: 1
    Max value: 5
    Step: 1
Parameter name: fixed
  Type: string
  Description: stays
  Constraints:
    Read only: true
"""


@on_dds_too
def test_parameters_are_shown(ros2: CommandLine) -> None:
    assert ros2.ok('param', 'dump', '/lab/workshop') == DUMP
    assert ros2.ok('param', 'describe', '/lab/workshop', 'gears', 'fixed') == DESCRIBED
    assert ros2.ok('param', 'get', '/lab/workshop', 'speed') == 'Double value is: 1.5\n'
    assert ros2.ok('param', 'get', '/lab/workshop', 'gears', '--hide-type') == '3\n'
    assert ros2.ok('param', 'get', '/lab/workshop', 'arm.names') == "String values are: ['left', 'right']\n"
    assert ros2.ok('param', 'list').splitlines()[:3] == ['/lab/workshop:', '  arm.names', '  fixed']
    assert (
        ros2.ok('param', 'list', '/lab/workshop', '--filter', '^g', '--param-type')
        == '  gears (type: integer)\n'
    )
    told = json.loads(ros2.ok('param', 'get', '/lab/workshop', 'arm.names', '--json'))
    assert told == {
        'node': '/lab/workshop',
        'name': 'arm.names',
        'type': 'string array',
        'value': ['left', 'right'],
    }


def test_parameters_are_changed(ros2: CommandLine, tmp_path: Path) -> None:
    assert ros2.ok('param', 'set', '/lab/workshop', 'gears', '4') == 'Set parameter successful\n'
    assert ros2.ok('param', 'set', '/lab/workshop', 'gears=3', 'speed=-2.5').splitlines() == [
        'gears: Set parameter successful',
        'speed: Set parameter successful',
    ]
    assert ros2.ok('param', 'set', '/lab/workshop', 'speed', '-0.5') == 'Set parameter successful\n'
    told = ros2.fails('param', 'set', '/lab/workshop', 'speed', '20.5', code=7)
    assert told == 'Setting parameter failed: too fast'
    assert 'Deleting parameter failed' in ros2.fails('param', 'delete', '/lab/workshop', 'gears', code=7)
    file = tmp_path / 'workshop.yaml'
    file.write_text('/lab/workshop:\n  ros__parameters:\n    speed: 1.5\n', encoding='utf-8')
    assert ros2.ok('param', 'load', '/lab/workshop', str(file)) == 'Set parameter speed successful\n'
    assert "has no parameter 'gear'; did you mean 'gears'?" in ros2.fails(
        'param', 'get', '/lab/workshop', 'gear', code=3
    )
    assert 'is given no value' in ros2.fails('param', 'set', '/lab/workshop', 'gears', code=2)
    assert 'nowhere.yaml' in ros2.fails('param', 'load', '/lab/workshop', 'nowhere.yaml', code=3)
    assert "there is no node '/nobody'" in ros2.fails('param', 'list', '/nobody', code=3)


def test_a_lifecycle_node_is_led_through_its_states(world: dict[str, str], start: Start) -> None:
    start('lamp').expect('^ready$')
    ros2 = CommandLine(world)
    assert ros2.ok('lifecycle', 'nodes') == '/lamp\n'
    assert ros2.ok('lifecycle', 'get', '/lamp') == 'unconfigured [1]\n'
    assert ros2.ok('lifecycle', 'get') == '/lamp: unconfigured [1]\n'
    assert ros2.ok('lifecycle', 'list', '/lamp') == (
        '- configure [1]\n\tStart: unconfigured\n\tGoal: configuring\n'
        '- shutdown [5]\n\tStart: unconfigured\n\tGoal: shuttingdown\n'
    )
    assert ros2.ok('lifecycle', 'set', '/lamp', 'configure') == 'Transitioning successful\n'
    told = ros2.fails('lifecycle', 'set', '/lamp', 'configure', code=4)
    assert "cannot do 'configure' now; available are: " in told
    assert 'activate [3]' in told
    assert ros2.ok('lifecycle', 'set', '/lamp', '3') == 'Transitioning successful\n'
    assert ros2.ok('lifecycle', 'get', 'lamp') == 'active [3]\n'


def test_a_node_without_a_lifecycle_is_told(ros2: CommandLine) -> None:
    assert 'has no lifecycle' in ros2.fails('lifecycle', 'get', '/lab/workshop', code=3)
