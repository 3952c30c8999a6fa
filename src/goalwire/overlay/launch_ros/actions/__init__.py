"""launch_ros.actions: nodes, and what holds for nodes."""

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
    RosTimer,
    SetParameter,
    SetParametersFromFile,
    SetRemap,
    SetROSLogDir,
    SetUseSimTime,
)

__all__ = [
    'ComposableNodeContainer',
    'LifecycleNode',
    'LifecycleTransition',
    'LoadComposableNodes',
    'Node',
    'PushROSNamespace',
    'PushRosNamespace',
    'RosTimer',
    'SetParameter',
    'SetParametersFromFile',
    'SetROSLogDir',
    'SetRemap',
    'SetUseSimTime',
]

add_modules(__name__, {'PushRosNamespace': 'push_ros_namespace', 'SetROSLogDir': 'set_ros_log_dir'})
