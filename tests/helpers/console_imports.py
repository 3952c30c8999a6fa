"""All that consoles and the robots beside them import and build at start and at a console's first page.

The server that forks them imports this module, and with it all of that, once for all of them.
"""

from __future__ import annotations

from importlib import import_module

from nicegui.client import templates
from rosidl_runtime_py.utilities import get_interface

_MODULES = (
    'anyio._backends._asyncio',
    'anyio.streams.tls',
    'fastapi.middleware.gzip',
    'goalwire.apps.cli.commands.console',
    'goalwire.apps.cli.main',
    'goalwire.apps.console.server',
    'goalwire.idl.editor_stubs',
    'goalwire.rules.statistics',
    'goalwire.transport.zenoh.embedded_router',
    'goalwire.transport.zenoh.rendezvous',
    'goalwire.zenoh.io.native_session',
    'nicegui.defaults',
    'nicegui.elements.checkbox',
    'nicegui.elements.colors',
    'nicegui.elements.dark_mode',
    'nicegui.elements.echart.echart',
    'nicegui.elements.expansion',
    'nicegui.elements.icon',
    'nicegui.elements.input',
    'nicegui.elements.menu',
    'nicegui.elements.number',
    'nicegui.elements.select',
    'nicegui.elements.slider',
    'nicegui.elements.switch',
    'nicegui.elements.tooltip',
    'nicegui.elements.tree',
    'nicegui.functions.html',
    'nicegui.functions.javascript',
    'nicegui.ui_run_with',
    'uvicorn.lifespan.on',
    'uvicorn.protocols.websockets.websockets_sansio_impl',
)
_INTERFACES = (
    'action_msgs/msg/GoalStatusArray',
    'action_msgs/srv/CancelGoal',
    'console_interfaces/action/GoTo',
    'control_msgs/action/FollowJointTrajectory',
    'example_interfaces/action/Fibonacci',
    'geometry_msgs/msg/TransformStamped',
    'rcl_interfaces/msg/Log',
    'rcl_interfaces/msg/ParameterDescriptor',
    'rcl_interfaces/msg/ParameterEvent',
    'rcl_interfaces/srv/DescribeParameters',
    'rcl_interfaces/srv/GetParameters',
    'rcl_interfaces/srv/GetParameterTypes',
    'rcl_interfaces/srv/ListParameters',
    'rcl_interfaces/srv/SetParameters',
    'rcl_interfaces/srv/SetParametersAtomically',
    'sensor_msgs/msg/BatteryState',
    'sensor_msgs/msg/Image',
    'sensor_msgs/msg/JointState',
    'service_msgs/msg/ServiceEventInfo',
    'std_msgs/msg/Bool',
    'std_msgs/msg/Float64',
    'std_msgs/msg/String',
    'std_srvs/srv/SetBool',
    'std_srvs/srv/Trigger',
    'tf2_msgs/msg/TFMessage',
    'trajectory_msgs/msg/JointTrajectory',
    'type_description_interfaces/srv/GetTypeDescription',
)

for _module in _MODULES:
    import_module(_module)
for _interface in _INTERFACES:
    get_interface(_interface)
templates.get_template('index.html')  # compiled: a tenth of a second
