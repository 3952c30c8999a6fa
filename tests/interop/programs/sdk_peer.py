"""zenoh-ros2-sdk as an echo, a service server or a service client, as its first argument says."""

import os
import sys
import threading
from typing import Any

from zenoh_ros2_sdk import (  # type: ignore[import-not-found]
    ROS2Publisher,
    ROS2ServiceClient,
    ROS2ServiceServer,
    ROS2Subscriber,
    ZenohSession,
)

STRING = {'msg_type': 'std_msgs/msg/String', 'msg_definition': 'string data\n'}
SWITCH = {
    'service_name': '/switch',
    'srv_type': 'std_srvs/srv/SetBool',
    'request_definition': 'bool data\n',
    'response_definition': 'bool success\nstring message\n',
}
HERE: dict[str, Any] = {'router_port': int(os.environ['GOALWIRE_ROUTER_PORT']), 'node_name': 'sdk_peer'}


def echo() -> None:
    said = ROS2Publisher('/from_peer', **STRING, **HERE)
    ROS2Subscriber(
        '/to_peer', callback=lambda message: said.publish(data=f'echo of {message.data}'), **STRING, **HERE
    )
    print('ready', flush=True)
    threading.Event().wait()


def serve() -> None:
    def switch(request: Any) -> Any:
        return server.response_msg_class(success=True, message='it is on' if request.data else 'it is off')

    server = ROS2ServiceServer(callback=switch, **SWITCH, **HERE)
    print('ready', flush=True)
    threading.Event().wait()


def call() -> None:
    client = ROS2ServiceClient(**SWITCH, **HERE)
    for on in (True, False):
        answer = client.call(data=on)
        print(answer.success, answer.message, flush=True)
    client.close()
    ZenohSession.get_instance().session.close()


{'echo': echo, 'serve': serve, 'call': call}[sys.argv[1]]()
