"""Transforms asked for in another process, as tf2_ros' buffer_server answers."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from builtin_interfaces.msg import Time as TimeMessage
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import Header
from tf2_msgs.action import LookupTransform
from tf2_msgs.msg import TF2Error
from tf2_ros import (
    BufferClient,
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

ERRORS: dict[type[TransformException], int] = {
    LookupException: TF2Error.LOOKUP_ERROR,
    ConnectivityException: TF2Error.CONNECTIVITY_ERROR,
    ExtrapolationException: TF2Error.EXTRAPOLATION_ERROR,
    InvalidArgumentException: TF2Error.INVALID_ARGUMENT_ERROR,
}


class Server:
    """An action server that looks up transforms."""

    def __init__(self, node: Node) -> None:
        self.handle = BufferCore()
        self.hold = threading.Event()
        self.hold.set()
        self.goals: list[LookupTransform.Goal] = []
        ActionServer(node, LookupTransform, 'tf2_buffer_server', self._execute)

    def tell(self, parent: str, child: str, x: float, seconds: int) -> None:
        self.handle.set_transform(
            TransformStamped(
                header=Header(frame_id=parent, stamp=TimeMessage(sec=seconds)),
                child_frame_id=child,
                transform=Transform(translation=Vector3(x=x)),
            ),
            'test',
        )

    def _execute(self, handle: ServerGoalHandle) -> LookupTransform.Result:
        goal, result = handle.request, LookupTransform.Result()
        self.goals.append(goal)
        self.hold.wait(PATIENCE)
        try:
            if goal.advanced:
                result.transform = self.handle.lookup_transform_full_core(
                    goal.target_frame, goal.target_time, goal.source_frame, goal.source_time, goal.fixed_frame
                )
            else:
                result.transform = self.handle.lookup_transform_core(
                    goal.target_frame, goal.source_frame, goal.source_time
                )
        except TransformException as error:
            result.error = TF2Error(error=ERRORS[type(error)], error_string=str(error))
        handle.succeed()
        return result


@pytest.fixture
def server(make_node: MakeNode, spin: Spin) -> Iterator[Server]:
    node = make_node('buffer_server')
    server = Server(node)
    server.tell('map', 'base', 1.0, seconds=1)
    server.tell('map', 'base', 3.0, seconds=2)
    server.tell('elsewhere', 'island', 1.0, seconds=2)
    spin(node)
    yield server
    server.hold.set()


@pytest.fixture
def client(server: Server, make_node: MakeNode) -> BufferClient:
    client = BufferClient(make_node('asker'), 'tf2_buffer_server')
    assert client.action_client.wait_for_server(10)
    return client


def test_a_lookup_is_answered_by_the_server(client: BufferClient, server: Server) -> None:
    found = client.lookup_transform('map', 'base', Time(nanoseconds=1_500_000_000), Duration(seconds=1.5))
    assert found.transform.translation.x == 2.0
    assert (found.header.frame_id, found.child_frame_id) == ('map', 'base')
    assert (server.goals[0].timeout.sec, server.goals[0].timeout.nanosec) == (1, 500_000_000)
    assert client.lookup_transform('map', 'base', TimeMessage(sec=2)).transform.translation.x == 3.0


def test_a_full_lookup_is_answered_by_the_server(client: BufferClient) -> None:
    times = Time(seconds=2), Time(seconds=1)
    found = client.lookup_transform_full('base', times[0], 'base', times[1], 'map')
    assert found.transform.translation.x == -2.0
    assert client.can_transform_full('base', times[0], 'base', times[1], 'map')
    assert not client.can_transform_full('base', times[0], 'base', times[1], 'nope')


@pytest.mark.parametrize(
    ('target', 'seconds', 'error'),
    [
        ('nope', 1, LookupException),
        ('island', 2, ConnectivityException),
        ('map', 9, ExtrapolationException),
        ('/map', 1, InvalidArgumentException),
    ],
)
def test_the_servers_reason_is_raised_here(
    client: BufferClient, target: str, seconds: int, error: type[TransformException]
) -> None:
    with pytest.raises(error, match=target if error is not ExtrapolationException else 'into the future'):
        client.lookup_transform(target, 'base', Time(seconds=seconds))
    assert not client.can_transform(target, 'base', Time(seconds=seconds))


def test_a_missing_server_is_told_at_once(make_node: MakeNode) -> None:
    client = BufferClient(make_node(), 'nobody')
    with pytest.raises(TimeoutException, match='not ready'):
        client.lookup_transform('map', 'base', Time(), Duration(seconds=100))


def test_a_server_that_hangs_is_told_after_timeout_and_padding(client: BufferClient, server: Server) -> None:
    server.hold.clear()
    client.timeout_padding = Duration(seconds=0.05)
    with pytest.raises(TimeoutException, match='did not come back'):
        client.lookup_transform('map', 'base', Time(), Duration(seconds=0.05))


def test_a_destroyed_client_is_gone(client: BufferClient) -> None:
    client.destroy()
    client.destroy()
    with pytest.raises(InvalidHandle):
        client.action_client.send_goal(LookupTransform.Goal())
