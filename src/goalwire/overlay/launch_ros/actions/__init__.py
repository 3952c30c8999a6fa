"""launch_ros.actions: the actions that start nodes, and that make settings for nodes."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.ros.composition import (
    ComposableNodeContainer,
    LoadComposableNodes,
)
from goalwire.launching.ros.lifecycle import (
    LifecycleNode,
    LifecycleTransition,
)
from goalwire.launching.ros.node import (
    Node,
)
from goalwire.launching.ros.scope import (
    PushROSNamespace,
    PushRosNamespace,
    ROSTimer,
    SetParameter,
    SetParametersFromFile,
    SetRemap,
    SetROSLogDir,
    SetUseSimTime,
)
from launch_ros.actions import load_composable_nodes  # noqa: F401 - before its alias would be made

__all__ = [
    'ComposableNodeContainer',
    'LifecycleNode',
    'LifecycleTransition',
    'LoadComposableNodes',
    'Node',
    'PushROSNamespace',
    'PushRosNamespace',
    'ROSTimer',
    'RosTimer',
    'SetParameter',
    'SetParametersFromFile',
    'SetROSLogDir',
    'SetRemap',
    'SetUseSimTime',
]

RosTimer = ROSTimer

add_modules(__name__, {'PushRosNamespace': 'push_ros_namespace'})
