"""goalwire bridge foxglove, as a client sees it that speaks the protocol word by word."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from helpers.bridge import Bridge, FoxgloveClient, start_bridge
from helpers.processes import Program
from websockets.exceptions import InvalidStatus

from goalwire.cdr import codec

Start = Callable[..., Bridge]


@pytest.fixture(scope='module')
def foxglove(world: dict[str, str], robot: Program) -> Iterator[str]:
    """The address of a bridge beside the robot."""
    with ExitStack() as stack:
        yield start_bridge(stack, world, 'foxglove').url


@pytest.fixture
def client(foxglove: str) -> Iterator[FoxgloveClient]:
    """A client that has seen what the robot has."""
    with FoxgloveClient(foxglove) as connected:
        yield connected


def _text(data: str) -> bytes:
    from std_msgs.msg import String

    return codec.encode(String(data=data))


def _say(client: FoxgloveClient, *texts: str) -> None:
    channel = {'id': 1, 'topic': '/say', 'encoding': 'cdr', 'schemaName': 'std_msgs/msg/String'}
    client.send('advertise', channels=[channel])
    for text in texts:
        client.socket.send(struct.pack('<BI', 1, 1) + _text(text))


def test_topics_are_shown_with_their_schemas(client: FoxgloveClient) -> None:
    channel = client.channel('/picture')
    assert (channel['encoding'], channel['schemaEncoding']) == ('cdr', 'ros2msg')
    assert channel['schemaName'] == 'sensor_msgs/msg/Image'
    assert 'MSG: std_msgs/Header' in channel['schema']


def test_a_subscriber_gets_the_history_as_it_was_sent(foxglove: str) -> None:
    for _ in range(2):
        with FoxgloveClient(foxglove) as client:
            client.subscribe('/robot_description', 7)
            kind, subscription, stamp = struct.unpack_from('<BIQ', frame := client.receive_bytes())
            assert (kind, subscription, frame[13:]) == (1, 7, _text('a robot'))
            assert stamp > 10**18


def test_a_topic_that_comes_and_goes_is_told(client: FoxgloveClient) -> None:
    channel = {'id': 5, 'topic': '/new', 'encoding': 'cdr', 'schemaName': 'std_msgs/msg/String'}
    client.send('advertise', channels=[channel])
    number = client.channel('/new')['id']
    client.send('unadvertise', channelIds=[5])
    assert client.expect('unadvertise')['channelIds'] == [number]


def test_a_client_publishes(client: FoxgloveClient, robot: Program) -> None:
    _say(client, 'hello')
    robot.expect('heard hello')


def test_bytes_that_are_not_a_message_are_refused_with_the_field(client: FoxgloveClient) -> None:
    _say(client)
    client.socket.send(struct.pack('<BI', 1, 1) + _text('cut short')[:-3])
    assert 'std_msgs/msg/String: data:' in client.expect('status')['message']


def test_a_service_is_called(client: FoxgloveClient) -> None:
    from example_interfaces.srv import AddTwoInts

    answer = client.call('/add', codec.encode(AddTwoInts.Request(a=1, b=2)))
    assert codec.decode(answer, AddTwoInts.Response).sum == 3
    assert 'needs' in client.call_fails('/add', b'\0\1\0\0')


def test_an_action_is_services_and_topics(client: FoxgloveClient) -> None:
    from example_interfaces.action import Fibonacci

    client.subscribe('/fibonacci/_action/feedback', 1)
    request = Fibonacci.Impl.SendGoalService.Request(goal=Fibonacci.Goal(order=4))
    request.goal_id.uuid = [7] * 16
    sent = client.call('/fibonacci/_action/send_goal', codec.encode(request))
    assert codec.decode(sent, Fibonacci.Impl.SendGoalService.Response).accepted
    feedback = codec.decode(
        client.feedback[0] if client.feedback else client.receive_bytes()[13:], Fibonacci.Impl.FeedbackMessage
    )
    assert list(feedback.feedback.sequence) == [0, 1, 1]
    asked = Fibonacci.Impl.GetResultService.Request()
    asked.goal_id.uuid = [7] * 16
    answer = client.call('/fibonacci/_action/get_result', codec.encode(asked))
    result = codec.decode(answer, Fibonacci.Impl.GetResultService.Response)
    assert (result.status, list(result.result.sequence)) == (4, [0, 1, 1, 2, 3])


def _long_goal(goal_id: int) -> bytes:
    from example_interfaces.action import Fibonacci

    request = Fibonacci.Impl.SendGoalService.Request(goal=Fibonacci.Goal(order=3000))
    request.goal_id.uuid = [goal_id] * 16
    return codec.encode(request)


def _send_long_goal(client: FoxgloveClient, goal_id: int) -> None:
    client.call('/fibonacci/_action/send_goal', _long_goal(goal_id))


def _cancelled(client: FoxgloveClient, goal_id: int) -> int:
    """Cancel a goal; return how many are cancelled."""
    from action_msgs.srv import CancelGoal

    request = CancelGoal.Request()
    request.goal_info.goal_id.uuid = [goal_id] * 16
    answer = client.call('/fibonacci/_action/cancel_goal', codec.encode(request))
    return len(codec.decode(answer, CancelGoal.Response).goals_canceling)


def test_a_client_that_is_lost_means_stop(foxglove: str, robot: Program) -> None:
    with FoxgloveClient(foxglove) as client:
        _send_long_goal(client, 8)
    robot.expect('cancelled')


def test_a_client_that_sends_the_id_of_another_s_goal_does_not_cancel_it(
    foxglove: str, client: FoxgloveClient, robot: Program
) -> None:
    """The server accepts no goal with an id that it knows; so the goal is not that client's."""
    client.subscribe('/fibonacci/_action/feedback', 1)
    _send_long_goal(client, 11)
    with FoxgloveClient(foxglove) as other:
        other.ask('/fibonacci/_action/send_goal', _long_goal(11))  # and is lost before the answer
    for _ in range(100):  # a second of it
        client.receive_bytes()
    assert _cancelled(client, 11) == 1, 'it was running still'
    robot.expect('cancelled')


def test_a_goal_is_cancelled_while_it_runs(client: FoxgloveClient, robot: Program) -> None:
    _send_long_goal(client, 9)
    assert _cancelled(client, 9) == 1
    robot.expect('cancelled')


def test_parameters_are_read_set_and_followed(client: FoxgloveClient) -> None:
    speed = {'name': '/robot.speed', 'type': 'float64'}
    client.send('subscribeParameterUpdates', parameterNames=['/robot.speed'])
    client.send('setParameters', id='s', parameters=[{**speed, 'value': 2}])
    told = [client.expect('parameterValues') for _ in range(2)]
    assert {'op': 'parameterValues', 'parameters': [{**speed, 'value': 2.0}], 'id': 's'} in told
    assert {'op': 'parameterValues', 'parameters': [{**speed, 'value': 2.0}]} in told
    client.send('setParameters', parameters=[{'name': '/robot.speed', 'value': 'fast'}])
    assert "'/robot.speed' was not set" in client.expect('status')['message']
    client.send('getParameters', id='g', parameterNames=[])
    names = [each['name'] for each in client.expect('parameterValues')['parameters']]
    assert {'/robot.speed', '/robot.use_sim_time'} <= set(names)


def test_the_connection_graph_is_sent(client: FoxgloveClient) -> None:
    client.send('subscribeConnectionGraph')
    update = client.expect('connectionGraphUpdate')
    assert {'name': '/picture', 'publisherIds': ['/robot']} in update['publishedTopics']
    assert {'name': '/say', 'subscriberIds': ['/robot']} in update['subscribedTopics']
    assert {'name': '/add', 'providerIds': ['/robot']} in update['advertisedServices']


@pytest.mark.parametrize(
    ('uri', 'problem'),
    [
        ('package://std_msgs/package.xml', ''),
        ('package://std_msgs/../geometry_msgs/package.xml', 'files outside of the package are not served'),
        ('package://std_msgs//etc/passwd', 'files outside of the package are not served'),
        ('package://std_msgs/no.stl', 'has no such file'),
        ('package://no_msgs/no.stl', "there is no package 'no_msgs' here"),
        ('file:///etc/passwd', 'only addresses of the form'),
    ],
)
def test_assets_come_out_of_packages_alone(client: FoxgloveClient, uri: str, problem: str) -> None:
    client.send('fetchAsset', uri=uri, requestId=3)
    kind, request, status, length = struct.unpack_from('<BIBI', frame := client.receive_bytes())
    assert (kind, request, status) == (4, 3, int(bool(problem)))
    assert problem in frame[10 : 10 + length].decode()
    assert frame.endswith(b'</package>\n') == (not problem)


@pytest.mark.parametrize(
    'frame',
    ['{', '[]', '{"op": "no"}', b'', b'\1', b'\2\0\0\0\0', b'\xff', '[' * 100_000,
     json.dumps({'op': 'subscribe', 'subscriptions': [{'id': 1, 'channelId': 9999}]}),
     json.dumps({'op': 'advertise', 'channels': [{'id': 1, 'encoding': 'json'}]})],
)  # fmt: skip
def test_what_is_wrong_is_told_to_the_client(client: FoxgloveClient, frame: Any) -> None:
    client.socket.send(frame)
    assert client.expect('status')['level'] == 2


def test_allow_lists_hide_names_and_refuse_them(bridge: Start, robot: Program) -> None:
    url = bridge('foxglove', '--actions', '/none', '--publish', '/none', '--parameters', '/none').url
    with FoxgloveClient(url) as client:
        assert not [name for name in (*client.channels, *client.services) if '/_action/' in name]
        _say(client, 'x')
        assert '--publish' in client.expect('status')['message']
        client.send('getParameters', id='g', parameterNames=[])
        assert client.expect('parameterValues')['parameters'] == []


def test_a_page_of_another_site_is_refused(bridge: Start) -> None:
    url = bridge('foxglove').url
    with pytest.raises(InvalidStatus, match='403'), FoxgloveClient(url, origin='https://evil.example'):
        pytest.fail('it was let in')
