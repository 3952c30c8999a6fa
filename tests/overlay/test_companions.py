"""The behaviour that all companions of rclpy have in common."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMPANIONS = [
    'ament_index_python',
    'diagnostic_updater',
    'message_filters',
    'rosidl_adapter',
    'rosidl_runtime_py',
    'sensor_msgs_py',
    'tf2_geometry_msgs',
    'tf2_py',
    'tf2_ros',
    'tf2_sensor_msgs',
]
LAUNCH = ['launch', 'launch_ros', 'launch_xml', 'launch_yaml']
WITH_NUMPY = ['tf_transformations']
HEAVY = ['asyncio', 'numpy', 'rich', 'yaml']


def run(program: str, **variables: str) -> str:
    done = subprocess.run(
        [sys.executable, '-c', program],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=True,
        timeout=30,
    )
    return done.stdout.strip()


@pytest.mark.parametrize('name', COMPANIONS)
def test_importing_one_loads_nothing_heavy(name: str) -> None:
    program = f'import {name}, sys; print([module for module in {HEAVY} if module in sys.modules])'
    assert run(program) == '[]'


def test_those_of_a_ros_2_on_the_path_come_first(tmp_path: Path) -> None:
    companions = COMPANIONS + WITH_NUMPY + LAUNCH
    for name in companions:
        (tmp_path / name).mkdir()
        (tmp_path / name / '__init__.py').write_text('', encoding='utf-8')
    imports = ', '.join(companions)
    files = run(f'import {imports}\nfor m in ({imports}): print(m.__file__)', PYTHONPATH=str(tmp_path))
    assert files.splitlines() == [str(tmp_path / name / '__init__.py') for name in companions]


def test_those_that_pip_has_installed_come_first() -> None:
    program = (
        'import sys, sysconfig, launch; from pathlib import Path\n'
        "installed = sys.path.index(sysconfig.get_path('purelib'))\n"
        'print(installed < sys.path.index(str(Path(launch.__file__).parents[1])))'
    )
    assert run(program) == 'True'


@pytest.mark.parametrize('name', COMPANIONS + WITH_NUMPY)
def test_what_one_promises_is_there(name: str) -> None:
    module = __import__(name)
    for attribute in getattr(module, '__all__', ()):
        assert getattr(module, attribute) is not None


AS_PROGRAMS_IMPORT_THEM = """
from ament_index_python import get_package_share_directory, get_package_share_path
from ament_index_python.packages import PackageNotFoundError, get_package_prefix, get_packages_with_prefixes
from ament_index_python.packages import get_package_share_directory
from ament_index_python.resources import get_resource, get_resources, has_resource
from diagnostic_updater import DiagnosedPublisher, DiagnosticStatusWrapper, DiagnosticTask, FrequencyStatus
from diagnostic_updater import FrequencyStatusParam, FunctionDiagnosticTask, TimeStampStatusParam, Updater
from diagnostic_updater._diagnostic_status_wrapper import DiagnosticStatusWrapper
from diagnostic_updater._diagnostic_updater import CompositeDiagnosticTask, DiagnosticTask, Updater
from diagnostic_updater._publisher import DiagnosedPublisher, HeaderlessTopicDiagnostic, TopicDiagnostic
from diagnostic_updater._update_functions import FrequencyStatus, Heartbeat, TimeStampStatus
from message_filters import ApproximateTimeSynchronizer, Cache, SimpleFilter, Subscriber, TimeSynchronizer
from rosidl_runtime_py import get_interface_path, message_to_csv, message_to_ordereddict, message_to_yaml
from rosidl_runtime_py import set_message_fields
from rosidl_runtime_py.convert import message_to_ordereddict, message_to_yaml
from rosidl_runtime_py.import_message import import_message_from_namespaced_type
from rosidl_runtime_py.set_message import set_message_fields
from rosidl_runtime_py.utilities import get_action, get_interface, get_message, get_service
from rosidl_adapter.parser import MessageSpecification, parse_message_file, parse_message_string
from rosidl_parser.definition import AbstractSequence, Array, BasicType, NamespacedType, UnboundedString
from rclpy.type_support import check_for_type_support, check_is_valid_msg_type, check_is_valid_srv_type
from sensor_msgs_py import point_cloud2
from sensor_msgs_py import point_cloud2 as pc2
from sensor_msgs_py.point_cloud2 import create_cloud, create_cloud_xyz32, read_points, read_points_numpy
from tf2_geometry_msgs import PointStamped, PoseStamped, do_transform_point, do_transform_pose
from tf2_geometry_msgs.tf2_geometry_msgs import PoseWithCovarianceStamped, do_transform_pose_stamped
from tf2_geometry_msgs import do_transform_pose_with_covariance_stamped, do_transform_vector3
from tf2_py import BufferCore, TransformException
from tf2_ros import Buffer, BufferClient, BufferInterface, TransformBroadcaster, TransformListener
from tf2_ros import ConnectivityException, ExtrapolationException, InvalidArgumentException, TimeoutException
from tf2_ros import StaticTransformBroadcaster, TransformStamped
from tf2_ros import TransformException, LookupException
from tf2_ros.buffer import Buffer
from tf2_ros.buffer_client import BufferClient
from tf2_ros.buffer_interface import BufferInterface, ConvertRegistration, Stamped, TransformRegistration
from tf2_ros.buffer_interface import NotImplementedException, TypeException, convert
from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster
from tf2_ros.static_transform_listener import StaticTransformListener
from tf2_ros.transform_broadcaster import TransformBroadcaster
from tf2_ros.transform_listener import TransformListener
from tf2_sensor_msgs import do_transform_cloud
from tf2_sensor_msgs.tf2_sensor_msgs import do_transform_cloud
from tf_transformations import euler_from_quaternion, quaternion_from_euler, quaternion_multiply
from unique_identifier_msgs.msg import UUID
"""


def test_all_is_found_where_programs_import_it_from() -> None:
    assert run(f'{AS_PROGRAMS_IMPORT_THEM}\nprint(TransformStamped.__name__)') == 'TransformStamped'


def test_a_star_import_brings_what_programs_take_from_it() -> None:
    program = (
        'from tf2_ros import *\nfrom tf2_geometry_msgs import *\n'
        'print(TransformStamped.__name__, BufferClient.__name__, PoseStamped.__name__)\n'
        'import tf2_ros; print(tf2_ros.buffer_client.BufferClient is BufferClient)'
    )
    assert run(program) == 'TransformStamped BufferClient PoseStamped\nTrue'


def test_the_action_client_is_not_loaded_for_transforms() -> None:
    assert run("import tf2_ros, sys; print('rclpy.action' in sys.modules)") == 'False'
