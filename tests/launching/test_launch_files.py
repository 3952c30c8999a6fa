"""Ten launch files as people write them: which processes they start, and how."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest
from helpers.wires import DDS, require
from launching.conftest import Launch

pytestmark = pytest.mark.skipif('sys.platform == "win32"', reason='processes are counted in /proc')

PARAMS_FILE = {'rate': 20, 'frame': 'base_link'}
SIM = {'use_sim_time': False}


def navigation(
    namespace: str, share: Path, speed: float = 1.0, planner: str = 'grid'
) -> list[dict[str, Any]]:
    """Return the processes that navigation.launch.xml and its twin start, below a namespace."""
    own = {'-p': SIM} if namespace else {}
    return [
        {
            'program': 'controller',
            'name': f'{namespace}/nav',
            'params': {**own, '/**': PARAMS_FILE},
            'remaps': ['odom:=/odometry'],
        },
        {
            'program': 'planner',
            'name': f'{namespace}/nav/planner',
            'argv': ['--kind', planner, 'two words'],
            'params': {
                **own,
                f'{namespace}/nav/planner': {
                    'limit': 2 * speed,
                    'label': '7',
                    'controller.gain': 0.25,
                    'controller.joints': ['a', 'b'],
                },
            },
            'remaps': ['odom:=/odometry', 'cmd_vel:=/cmd_vel'],
            'env': {'DEMO_HOME': str(share)},
        },
    ]


@pytest.fixture
def share(prefix: Path) -> Path:
    """The folder of demo_robot's own files."""
    return prefix / 'share' / 'demo_robot'


def test_a_composed_bringup(launch: Launch, share: Path) -> None:
    with launch('bringup.launch.py') as robot:
        tree = robot.tree(6)
        assert tree == [
            {'program': 'camera', 'name': '/cameras/camera', 'params': {'-p': SIM}},
            navigation('/robot', share, 0.5)[0],
            {
                'program': 'lidar',
                'name': '/robot/sensors/lidar',
                'params': {
                    '-p': SIM,
                    '/robot/sensors/lidar': {
                        'port': '/dev/ttyUSB0',
                        'angles': [-1.5, 1.5],
                        'filter.on': True,
                    },
                },
            },
            navigation('/robot', share, 0.5)[1],
            {
                'program': 'state_publisher',
                'name': '/robot/state_publisher',
                'params': {
                    '-p': SIM,
                    '/**': PARAMS_FILE,
                    '/robot/state_publisher': {'publish_frequency': 30.0},
                },
                'remaps': ['/tf:=tf', '/tf_static:=tf_static'],
            },
            {'program': 'teleop', 'argv': ['--device', '0']},
        ]
        robot.end()


def test_arguments_change_a_bringup(launch: Launch) -> None:
    arguments = ('namespace:=ant', 'use_sim_time:=true', 'use_camera:=false', 'use_camera:=True')
    with launch('bringup.launch.py', *arguments) as robot:
        assert [process.program for process in robot.started(5)] == [
            'camera',
            'controller',
            'lidar',
            'planner',
            'state_publisher',
        ]
        assert {process.params['-p']['use_sim_time'] for process in robot.processes} == {True}
        assert {process.ns for process in robot.processes} == {'/ant', '/ant/nav', '/ant/sensors', '/cameras'}
        robot.end()


@pytest.mark.parametrize('ending', ['xml', 'yaml'])
def test_twins_in_xml_and_yaml(ending: str, launch: Launch, share: Path) -> None:
    with launch(f'navigation.launch.{ending}', 'speed:=1.5') as robot:
        assert robot.tree(2) == navigation('', share, 1.5)
        robot.end()


@pytest.mark.parametrize('ending', ['xml', 'yaml'])
def test_conditions_of_twins(ending: str, launch: Launch, share: Path) -> None:
    with launch(f'navigation.launch.{ending}', 'planner:=lattice') as robot:
        assert robot.tree(1) == navigation('', share, planner='lattice')[1:]
        robot.end()


@pytest.mark.parametrize('ending', ['xml', 'yaml'])
def test_several_robots_by_includes(ending: str, launch: Launch) -> None:
    with launch(f'multi_robot.launch.{ending}') as robots:
        site = {'DEMO_SITE': 'lab'}
        assert robots.tree(3) == [
            {
                'program': 'arm',
                'name': '/arm_left/arm',
                'params': {'-p': {'side': 'left'}, '/arm_left/arm': {'joints': 6, 'label': 'lab arm'}},
                'env': site,
            },
            {
                'program': 'arm',
                'name': '/arm_right/arm',
                'params': {'/arm_right/arm': {'joints': 7, 'label': 'none'}},
                'env': site,
            },
            {'program': 'plain', 'argv': ['monitor'], 'env': site},
        ]
        robots.end()
    with launch(f'multi_robot.launch.{ending}', 'base:=wheel') as robots:
        assert [process.ns for process in robots.started(2)] == ['/wheel_left', None]
        robots.end()


def test_a_fleet_made_by_a_function(launch: Launch) -> None:
    with launch('fleet.launch.py', 'count:=3') as fleet:
        assert fleet.tree(3) == [
            {
                'program': 'driver',
                'name': f'/robot_{index}/driver_{index}',
                'params': {
                    f'/robot_{index}/driver_{index}': {
                        'robot_description': f'robot_{index}\n',
                        'id': index,
                        'text': '5',
                        'number': 30,
                    },
                    '/**': {'home': f'robot_{index}_home', 'reach': 0.8},
                },
            }
            for index in range(3)
        ]
        fleet.end()


def test_environment_folder_prefix_and_terminal(launch: Launch) -> None:
    with launch('environment.launch.py') as started:
        plain = {process.argv[0]: process for process in started.started(3)}
        assert plain['inner'].env == {'DEMO_MODE': 'inner', 'DEMO_PATH': '/zero:/one', 'DEMO_MORE': '1'}
        assert plain['fallback'].env == {'DEMO_MODE': 'outer', 'DEMO_PREFIX': 'yes'}
        assert plain['last'].env == {}
        assert Path(plain['fallback'].cwd).name == 'config'
        assert [plain[name].tty for name in ('inner', 'fallback')] == [False, True]
        output = started.end()
        assert '[outer-2] plain is up' in output


def test_one_thing_after_the_other(launch: Launch) -> None:
    with launch('sequence.launch.py') as sequence:
        assert [process.program for process in sequence.started(2)] == ['short', 'spawner']
        output = sequence.ended()
    told = [line.partition(': ')[2] for line in output.splitlines() if '[launch.user]' in line]
    assert sorted(told[:3]) == ['calibrated', 'calibrating', 'first completed']
    assert told[3:] == ['the spawner said so', 'last-3 gave 5', 'shutting down: done']
    assert '[ERROR] [last-3]: process has died' in output


def test_a_node_is_respawned_and_a_required_one_ends_all(launch: Launch) -> None:
    with launch('respawn.launch.py') as robot:
        programs = [process.program for process in robot.started(5)]
        assert programs == ['base', 'driver', 'faulty', 'faulty', 'faulty']
        base = next(process for process in robot.processes if process.program == 'base')
        robot.program.expect(r'\[faulty-1\]: process has died')
        robot.program.expect(r'\[faulty-1\]: process has died')
        robot.program.expect(r'\[faulty-1\]: process has died')
        os.kill(base.pid, signal.SIGKILL)
        output = robot.ended()
    assert f'[ERROR] [base-2]: process has died [pid {base.pid}, exit code -9, cmd ' in output
    assert "[driver-3]: sending signal 'SIGINT'" in output


TF = ['/tf:=tf', '/tf_static:=tf_static']
BUFFERED = {'DEMO_BUFFERED': '1'}


def mobile_base(namespace: str, model: str, mode: str, separation: float) -> list[dict[str, Any]]:
    """Return the processes that mobile_base.launch.py starts in any case.

    They are the controller, the driver, the spawner and the state_publisher.
    """
    of_controller = {
        'wheel_separation': separation,
        'mode': mode,
        'plugins': ['static_layer', 'voxel_layer'],
    }
    name = f'{namespace}/controller_{model}'
    scan = ['scan:=front/scan']
    return [
        {
            'program': 'controller',
            'name': name,
            'params': {
                '-p': SIM,
                **_merged({'/**': PARAMS_FILE}, name if namespace else '/**', of_controller),
            },
            'remaps': scan + TF,
            'env': BUFFERED,
        },
        {'program': 'driver', 'name': '/driver', 'env': BUFFERED},
        {'program': 'short', 'argv': ['-entity', model], 'env': BUFFERED},
        {
            'program': 'state_publisher',
            'name': f'{namespace}/state_publisher',
            'params': {
                '-p': SIM,
                f'{namespace}/state_publisher' if namespace else '/**': {
                    'robot_description': f'<robot name="{model}"><link name="base"/></robot>\n'
                },
            },
            'remaps': scan + TF,
            'env': BUFFERED,
        },
    ]


def _merged(files: dict[str, Any], node: str, more: dict[str, Any]) -> dict[str, Any]:
    return {**files, node: {**files.get(node, {}), **more}}


def test_a_mobile_base_ends_with_its_driver(launch: Launch) -> None:
    with launch('mobile_base.launch.py') as robot:
        assert robot.tree(4) == mobile_base('', 'burger', 'driving', 0.16)
        robot.program.expect(r'\[launch.user\]: a small one: burger')
        robot.program.expect(r'\[launch.user\]: spawned burger')
        os.kill(next(each.pid for each in robot.processes if each.program == 'driver'), signal.SIGKILL)
        output = robot.ended()
    assert '[ERROR] [driver-4]: process has died' in output
    assert "[state_publisher-1]: sending signal 'SIGINT'" in output


def test_arguments_choose_the_parts_of_a_mobile_base(launch: Launch) -> None:
    arguments = ('use_namespace:=true', 'namespace:=tb', 'slam:=True', 'model:=waffle', 'log_level:=debug')
    with launch('mobile_base.launch.py', *arguments) as robot:
        found = robot.tree(6)
        slam = next(each for each in found if each['program'] == 'planner')
        assert [each for each in found if each['program'] not in {'planner', 'camera'}] == mobile_base(
            '/tb', 'waffle', 'mapping', 0.287
        )
        assert (slam['name'], slam['argv']) == ('/tb/slam', ['--log-level', 'debug'])
        assert slam['params'] == {'-p': SIM, '/**': PARAMS_FILE}
        assert next(each['name'] for each in found if each['program'] == 'camera') == '/tb/head'
        robot.end()
    with launch('mobile_base.launch.py', 'map:=lab.yaml', 'camera:=1') as robot:
        programs = [each.program for each in robot.started(6)]
        assert programs == ['camera', 'controller', 'driver', 'plain', 'short', 'state_publisher']
        robot.end()
    with launch('mobile_base.launch.py', 'use_composition:=True') as robot:
        robot.started(2)
        robot.program.expect("container '/container' does not answer: its components wait for it")
        robot.end()


@pytest.mark.parametrize('ending', ['xml', 'yaml'])
def test_a_site_in_xml_and_yaml(ending: str, launch: Launch, share: Path) -> None:
    site = {'DEMO_SITE': 'tb_waffle'}
    with launch(f'site.launch.{ending}', 'use_sim_time:=true', DEMO_MODEL='waffle') as robot:
        assert robot.tree(3) == [
            {
                'program': 'lidar',
                'name': '/tb_waffle/lidar',
                'argv': ['--log-level', 'warn'],
                'params': {
                    '-p': {'use_sim_time': True},
                    '/**': PARAMS_FILE,
                    '/tb_waffle/lidar': {'range': 3.5, 'frame_id': 'tb_waffle/scan'},
                },
                'remaps': ['/tf:=tf', 'scan:=front/scan'],
                'env': {'DEMO_MODEL': 'waffle', **site},
            },
            {
                'program': 'plain',
                'argv': ['record', '--topics', '/tf', 'two words'],
                'env': {'DEMO_BAG': 'tb_waffle_bag', 'DEMO_MODEL': 'waffle', **site},
            },
            {
                'program': 'state_publisher',
                'name': '/tb_waffle/state_publisher',
                'params': {
                    '-p': {'use_sim_time': True},
                    '/tb_waffle/state_publisher': {
                        'robot_description': '<robot name="waffle"><link name="base"/></robot>\n'
                    },
                },
                'remaps': ['/tf:=tf'],
                'env': {'DEMO_MODEL': 'waffle', **site},
            },
        ]
        assert next(each.cwd for each in robot.processes if each.program == 'plain') == str(share / 'launch')
        robot.end()
    with launch(f'site.launch.{ending}') as robot:  # a small one
        assert [each.program for each in robot.started(3)] == ['plain', 'short', 'state_publisher']
        assert next(each.argv for each in robot.processes if each.program == 'short') == ['burger_end']
        assert f'[launch.user]: tb_burger at {share / "launch"}' in robot.end()


@pytest.mark.parametrize('rmw', ['rmw_zenoh_cpp', DDS])
def test_a_managed_node_goes_from_state_to_state(rmw: str, launch: Launch) -> None:
    require(rmw)
    with launch('managed.launch.py', 'who:=the arm', RMW_IMPLEMENTATION=rmw) as robot:
        robot.program.expect(r'\[launch.user\]: activating the arm')
        robot.program.expect(r'\[launch.user\]: it is active')
        output = robot.end()
    assert '[arm.driver]: configured' in output  # the node's lines come at their own time
    assert '[arm.driver]: activated' in output
    assert '[INFO] [managed-1]: process has finished cleanly' in output


@pytest.mark.parametrize('tags', ['autostart="true"', ''])
def test_a_managed_node_that_is_started_by_the_launch(tags: str, launch: Launch, tmp_path: Path) -> None:
    file = tmp_path / 'managed.launch.xml'
    transition = (
        '' if tags else '<lifecycle_transition lifecycle_node_names="/arm/driver" transition_ids="1 3"/>'
    )
    file.write_text(
        '<launch>\n<lifecycle_node pkg="demo_robot" exec="managed" name="driver" namespace="arm" '
        f'output="screen" {tags}/>\n{transition}\n</launch>\n'
    )
    with launch(file) as robot:
        robot.program.expect(r'\[arm.driver\]: configured')
        robot.program.expect(r'\[arm.driver\]: activated')
        robot.end()


def test_a_transition_that_a_node_refuses_is_told(launch: Launch, tmp_path: Path) -> None:
    file = tmp_path / 'refused.launch.xml'
    file.write_text(
        '<launch>\n<lifecycle_node pkg="demo_robot" exec="managed" name="driver" namespace="arm"/>\n'
        '<lifecycle_transition lifecycle_node_names="/arm/driver" transition_ids="3"/>\n</launch>\n'
    )
    with launch(file) as robot:
        robot.program.expect(
            "Failed to make transition 'TRANSITION_ACTIVATE' for LifecycleNode '/arm/driver'"
        )
        robot.end()
