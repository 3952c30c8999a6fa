"""tf2_ros: sends, receives and looks up transforms in nodes.

In ROS 2 the package also re-exports the names that its modules import, and programs use these names. So
TransformStamped and others can be imported from this package, too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import (
    PointStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    TransformStamped,
    Vector3Stamped,
)
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from rclpy.time import Time
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from tf2_py import (
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

from goalwire.errors import NotImplementedException, TypeException
from tf2_ros.buffer import Buffer
from tf2_ros.buffer_interface import BufferInterface, Stamped
from tf2_ros.registration import ConvertRegistration, TransformRegistration, convert
from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster
from tf2_ros.static_transform_listener import StaticTransformListener
from tf2_ros.transform_broadcaster import TransformBroadcaster
from tf2_ros.transform_listener import TransformListener

if TYPE_CHECKING:
    from tf2_ros.buffer_client import BufferClient

__all__ = [
    'Buffer',
    'BufferClient',
    'BufferCore',
    'BufferInterface',
    'ConnectivityException',
    'ConvertRegistration',
    'DurabilityPolicy',
    'Duration',
    'ExtrapolationException',
    'Header',
    'HistoryPolicy',
    'InvalidArgumentException',
    'LookupException',
    'Node',
    'NotImplementedException',
    'PointStamped',
    'PoseStamped',
    'PoseWithCovarianceStamped',
    'QoSProfile',
    'Stamped',
    'StaticTransformBroadcaster',
    'StaticTransformListener',
    'TFMessage',
    'Time',
    'TimeoutException',
    'TransformBroadcaster',
    'TransformException',
    'TransformListener',
    'TransformRegistration',
    'TransformStamped',
    'TypeException',
    'Vector3Stamped',
    'convert',
]


def __getattr__(name: str) -> Any:
    """Import BufferClient at its first use: it loads actions, which few programs with transforms use."""
    if name in {'BufferClient', 'buffer_client'}:
        from importlib import import_module

        module = import_module('tf2_ros.buffer_client')
        return module if name == 'buffer_client' else module.BufferClient
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
