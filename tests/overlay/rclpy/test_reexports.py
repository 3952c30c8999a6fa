"""Names that programs take from modules of rclpy which only use them."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module

import pytest
from rclpy import _reexports


@pytest.mark.parametrize('module', _reexports.REEXPORTS)
def test_a_module_has_each_name_that_the_one_of_ros_2_has(module: str) -> None:
    for name in _reexports.REEXPORTS[module].split():
        assert hasattr(import_module(module), name), name


def test_a_reexports_name_is_the_very_thing() -> None:
    import rclpy.executors
    import rclpy.node
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterDescriptor
    from rclpy.task import Future

    assert getattr(rclpy.executors, 'Future') is Future  # noqa: B009 - no public name
    assert getattr(rclpy.node, 'ParameterDescriptor') is ParameterDescriptor  # noqa: B009
    assert getattr(rclpy.node, 'ParameterMsg') is ParameterMessage  # noqa: B009


def test_a_name_that_no_module_hands_on_is_missing() -> None:
    with pytest.raises(ImportError, match='Odometry'):
        exec('from rclpy.node import Odometry', {})


def test_the_exceptions_of_the_c_extension_are_those_that_are_raised() -> None:
    from rclpy import _rclpy_pybind11
    from rclpy.exceptions import InvalidHandle

    assert _rclpy_pybind11.InvalidHandle is InvalidHandle
    assert issubclass(_rclpy_pybind11.RMWError, RuntimeError)


def test_the_old_name_of_event_handler_warns() -> None:
    sys.modules.pop('rclpy.qos_event', None)
    with pytest.warns(UserWarning, match='event_handler'):
        module = import_module('rclpy.qos_event')
    assert (
        module.SubscriptionEventCallbacks is import_module('rclpy.event_handler').SubscriptionEventCallbacks
    )


def test_nothing_is_reexports_before_it_is_asked_for() -> None:
    code = 'import sys, rclpy.node; print("rcl_interfaces.msg" in sys.modules, "yaml" in sys.modules)'
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, timeout=30, check=True
    )
    assert result.stdout.split() == ['False', 'False']
