"""The works on zenoh-ros2-sdk: callbacks on Zenoh's threads, two processes that meet without a router.

usage: python -m benchmarks.peers.on_zenoh_ros2_sdk ask WORK COUNT | answer WORK PORT | first PORT
"""

from time import perf_counter

BEGUN = perf_counter()

import itertools  # noqa: E402
import os  # noqa: E402
import sys  # noqa: E402
from contextlib import suppress  # noqa: E402
from queue import Empty, SimpleQueue  # noqa: E402
from typing import TYPE_CHECKING, Any  # noqa: E402

from zenoh_ros2_sdk import (  # type: ignore[import-not-found]  # noqa: E402
    ROS2Publisher,
    ROS2ServiceClient,
    ROS2ServiceServer,
    ROS2Subscriber,
    ZenohSession,
)

if TYPE_CHECKING:
    from benchmarks.line import Figures

ME = 'benchmarks.peers.on_zenoh_ros2_sdk'
SWITCH = {
    'service_name': '/bench_switch',
    'srv_type': 'std_srvs/srv/SetBool',
    'request_definition': 'bool data\n',
    'response_definition': 'bool success\nstring message\n',
}
"""Types are given as text, since the package fetches others from the network."""
_SECTIONS = {
    'std_msgs/Header': 'builtin_interfaces/Time stamp\nstring frame_id',
    'builtin_interfaces/Time': 'int32 sec\nuint32 nanosec',
    'geometry_msgs/Pose': 'Point position\nQuaternion orientation',
    'geometry_msgs/Point': 'float64 x\nfloat64 y\nfloat64 z',
    'geometry_msgs/Quaternion': 'float64 x\nfloat64 y\nfloat64 z\nfloat64 w',
}
POSE = {
    'msg_type': 'geometry_msgs/msg/PoseStamped',
    'msg_definition': '\n'.join(
        ['std_msgs/Header header', 'Pose pose', *(f'{"=" * 80}\nMSG: {k}\n{v}' for k, v in _SECTIONS.items())]
    ),
    'type_hash': 'RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8',
}
PATIENCE_S = 20.0


def meet(*, listen: int = 0, connect: int = 0) -> None:
    """Say how sessions of this process are opened: they listen at one port, or connect to it."""
    ends = {
        key: f'["tcp/127.0.0.1:{port}"]' if port else '[]'
        for key, port in (('listen', listen), ('connect', connect))
    }
    overrides = [f'{key}/endpoints={value}' for key, value in ends.items()]
    os.environ['ZENOH_CONFIG_OVERRIDE'] = ';'.join([*overrides, 'scouting/multicast/enabled=false'])


def new_pose() -> dict[str, Any]:
    """Return the fields of a message."""
    types = ZenohSession.get_instance().store.types
    stamp = types['builtin_interfaces/msg/Time'](sec=0, nanosec=0)
    position = types['geometry_msgs/msg/Point'](x=0.0, y=0.0, z=0.0)
    orientation = types['geometry_msgs/msg/Quaternion'](x=0.0, y=0.0, z=0.0, w=1.0)
    return {
        'header': types['std_msgs/msg/Header'](stamp=stamp, frame_id='map'),
        'pose': types['geometry_msgs/msg/Pose'](position=position, orientation=orientation),
    }


def answer(work: str, port: int) -> None:
    """Do the other half of a work until the asking process ends."""
    from benchmarks import stage

    meet(listen=port)
    if work == 'topic':
        pong = ROS2Publisher('/bench_pong', **POSE)
        kept = ROS2Subscriber(
            '/bench_ping', callback=lambda pose: pong.publish(header=pose.header, pose=pose.pose), **POSE
        )
    else:

        def switch(request: Any) -> Any:
            return kept.response_msg_class(success=request.data, message='switched')

        kept = ROS2ServiceServer(callback=switch, **SWITCH)
    stage.obey({})
    ZenohSession.get_instance().session.close()


def ask(work: str, count: int) -> 'Figures':
    """Measure a work."""
    from helpers.isolation import free_port

    from benchmarks import stage
    from benchmarks.peers import first_answer

    port = free_port()
    with stage.Partner(ME, work, port) as partner:
        if work == 'start':
            return first_answer.measure(ME, count, port)
        meet(connect=port)
        exchange = prepare_topic() if work == 'topic' else prepare_service()
        figures = stage.round_trips(exchange, count, partner)
        ZenohSession.get_instance().session.close()
        return figures


def prepare_service() -> Any:
    """Return a function that calls the service."""
    client = ROS2ServiceClient(**SWITCH)

    def call() -> None:
        answer = client.call(data=True)
        assert answer is not None
        assert answer.success

    return call


def prepare_topic() -> Any:
    """Return a function that sends a message and waits until it has come back."""
    arrived: SimpleQueue[str] = SimpleQueue()
    ping = ROS2Publisher('/bench_ping', **POSE)
    ROS2Subscriber('/bench_pong', callback=lambda pose: arrived.put(pose.header.frame_id), **POSE)
    fields, numbers = new_pose(), itertools.count()
    stamp, header = fields['header'].stamp, type(fields['header'])

    def exchange() -> None:
        sent = str(next(numbers))
        fields['header'] = header(stamp=stamp, frame_id=sent)
        ping.publish(**fields)
        while arrived.get(timeout=PATIENCE_S) != sent:
            pass  # of the meeting

    while True:  # until both ends have found each other
        ping.publish(**fields)
        with suppress(Empty):
            arrived.get(timeout=0.1)
            return exchange


def first(port: int) -> None:
    from benchmarks.peers import first_answer

    meet(connect=port)
    prepare_service()()
    first_answer.tell(BEGUN)
    ZenohSession.get_instance().session.close()


if __name__ == '__main__':
    if sys.argv[1] == 'first':
        first(int(sys.argv[2]))
    else:
        from benchmarks import stage

        stage.run(ask, answer)
