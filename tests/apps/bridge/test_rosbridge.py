"""goalwire bridge rosbridge, as clients see it that speak the protocol word by word."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import pytest
from helpers.bridge import Bridge, WebSocket
from helpers.processes import Program
from websockets.exceptions import ConnectionClosed, InvalidStatus

cbor2 = pytest.importorskip('cbor2')
Start = Callable[..., Bridge]
FIBONACCI = {'action': '/fibonacci', 'action_type': 'example_interfaces/Fibonacci'}


@pytest.fixture
def client(rosbridge: str) -> Any:
    """A client of the bridge beside the robot."""
    with WebSocket(rosbridge) as connected:
        yield connected


def _say(client: WebSocket, text: str) -> None:
    client.send('publish', topic='/say', type='std_msgs/String', msg={'data': text})


def test_a_message_that_is_published_reaches_the_robot(client: WebSocket, robot: Program) -> None:
    client.send('advertise', topic='/say', type='std_msgs/String')
    client.send('publish', topic='/say', msg={'data': 'hello'})
    robot.expect('heard hello')


def test_bytes_are_base64_and_what_is_not_finite_is_null(client: WebSocket) -> None:
    client.send('subscribe', topic='/picture', type='sensor_msgs/Image')
    client.send('subscribe', topic='numbers', type='std_msgs/Float64MultiArray')
    client.call('/rosapi/get_time')
    _say(client, 'now')
    messages = {each['topic']: each['msg'] for each in (client.expect('publish'), client.expect('publish'))}
    assert messages['/picture']['data'] == 'AH//'
    assert messages['numbers']['data'] == [1.5, None, None]


@pytest.mark.parametrize('compression', ['cbor', 'cbor-raw'])
def test_a_subscriber_gets_cbor_if_it_asks_for_it(client: WebSocket, compression: str) -> None:
    client.send('subscribe', topic='/numbers', type='std_msgs/Float64MultiArray', compression=compression)
    client.call('/rosapi/get_time')
    _say(client, 'now')
    message = cbor2.loads(client.receive())['msg']
    if compression == 'cbor':
        assert message['data'].tag == 86
        assert len(message['data'].value) == 24
    else:
        assert message['bytes'][:4] == b'\0\1\0\0'
        assert message['secs'] > 0


def test_a_png_and_its_fragments_hold_the_message(client: WebSocket) -> None:
    from goalwire.apps.bridge.rosbridge.encoding import Assembler

    client.send(
        'subscribe', topic='/robot_description', type='std_msgs/String', compression='png', fragment_size=100
    )
    assembler, whole, fragments = Assembler(10_000), None, 0
    while whole is None or whole['op'] != 'publish':
        whole = assembler.add(whole or client.receive())
        fragments += 1
    assert whole['msg'] == {'data': 'a robot'}
    assert fragments > 2


def test_a_topic_with_history_reaches_each_client(rosbridge: str) -> None:
    for _ in range(2):
        with WebSocket(rosbridge) as client:
            client.send('subscribe', topic='/robot_description')
            assert client.expect('publish')['msg'] == {'data': 'a robot'}


def test_a_throttled_subscription_drops_the_oldest(client: WebSocket) -> None:
    client.send('subscribe', topic='/say', type='std_msgs/String', throttle_rate=300, queue_length=1)
    client.send('advertise', topic='/say', type='std_msgs/String')
    for number in range(20):
        _say(client, str(number))
    assert [client.expect('publish')['msg']['data'] for _ in range(2)] == ['0', '19']


def test_a_service_is_called(client: WebSocket) -> None:
    assert client.call('/add', a=1, b=2)['values'] == {'sum': 3}


def test_a_client_serves_a_service_for_another(rosbridge: str) -> None:
    with WebSocket(rosbridge) as server, WebSocket(rosbridge) as client:
        server.send('advertise_service', service='/twice', type='example_interfaces/AddTwoInts')
        server.call('/rosapi/get_time')
        client.send('call_service', id='c', service='/twice', args={'a': 4})
        request = server.expect('call_service')
        values = {'sum': 2 * request['args']['a']}
        server.send('service_response', id=request['id'], service='/twice', values=values, result=True)
        assert client.expect('service_response')['values'] == {'sum': 8}


def test_a_call_fails_when_the_client_that_serves_it_is_lost(rosbridge: str) -> None:
    with WebSocket(rosbridge) as client:
        with WebSocket(rosbridge) as server:
            server.send('advertise_service', service='/twice', type='example_interfaces/AddTwoInts')
            server.call('/rosapi/get_time')
            client.send('call_service', id='c', service='/twice', args={'a': 4})
            server.expect('call_service')
        assert client.expect('service_response')['result'] is False


def test_a_goal_sends_feedback_and_its_result(client: WebSocket) -> None:
    client.send('send_action_goal', id='g', args={'order': 4}, feedback=True, **FIBONACCI)
    seen = [client.expect('action_feedback')['values']['sequence'] for _ in range(3)]
    assert seen == [[0, 1, 1], [0, 1, 1, 2], [0, 1, 1, 2, 3]]
    result = client.expect('action_result')
    assert (result['id'], result['status'], result['result']) == ('g', 4, True)
    assert result['values'] == {'sequence': [0, 1, 1, 2, 3]}


def test_a_goal_is_cancelled_while_it_runs_and_tells_its_status(client: WebSocket) -> None:
    client.send('send_action_goal', id='g', args={'order': 3000}, feedback=True, status=True, **FIBONACCI)
    client.expect('action_feedback')
    client.send('cancel_action_goal', id='g', action='/fibonacci')
    client.expect('action_status', lambda each: each['status'] == 3)
    client.expect('action_status', lambda each: each['status'] == 5)
    assert client.expect('action_result')['status'] == 5


def test_a_client_that_is_lost_means_stop(rosbridge: str, robot: Program) -> None:
    with WebSocket(rosbridge) as client:
        client.send('send_action_goal', id='g', args={'order': 3000}, feedback=True, **FIBONACCI)
        client.expect('action_feedback')
    robot.expect('cancelled')


def test_with_keep_goals_a_goal_goes_on_without_its_client(bridge: Start, robot: Program) -> None:
    url = bridge('rosbridge', '--keep-goals').url
    with WebSocket(url) as watcher:
        watcher.send(
            'subscribe', topic='/fibonacci/_action/status', type='action_msgs/GoalStatusArray', queue_length=9
        )
        with WebSocket(url) as client:
            client.send('send_action_goal', id='g', args={'order': 40}, feedback=True, **FIBONACCI)
            client.expect('action_feedback')
        watcher.expect('publish', lambda each: each['msg']['status_list'][-1]['status'] == 4)


def test_a_client_serves_an_action_for_another(rosbridge: str) -> None:
    kind = {'action': '/count', 'action_type': 'example_interfaces/Fibonacci'}
    with WebSocket(rosbridge) as server, WebSocket(rosbridge) as client:
        server.send('advertise_action', action='/count', type='example_interfaces/Fibonacci')
        server.call('/rosapi/get_time')
        client.send('send_action_goal', id='g', args={'order': 2}, feedback=True, **kind)
        goal = server.expect('send_action_goal')
        assert goal['args'] == {'order': 2}
        server.send('action_feedback', id=goal['id'], action='/count', values={'sequence': [1]})
        assert client.expect('action_feedback')['values'] == {'sequence': [1]}
        client.send('cancel_action_goal', id='g', action='/count')
        assert server.expect('cancel_action_goal')['id'] == goal['id']
        values = {'sequence': [1, 2]}
        server.send('action_result', id=goal['id'], action='/count', values=values, status=5, result=True)
        result = client.expect('action_result')
        assert (result['status'], result['values']) == (5, values)


def test_a_goal_is_aborted_when_the_client_that_serves_it_is_lost(rosbridge: str) -> None:
    with WebSocket(rosbridge) as client:
        with WebSocket(rosbridge) as server:
            server.send('advertise_action', action='/count', type='example_interfaces/Fibonacci')
            server.call('/rosapi/get_time')
            client.send(
                'send_action_goal', id='g', action='/count', action_type='example_interfaces/Fibonacci'
            )
            server.expect('send_action_goal')
        assert client.expect('action_result')['status'] in {0, 6}  # aborted, or its server is gone


@pytest.mark.parametrize(
    ('operation', 'text'),
    [
        ({'op': 'publish', 'topic': '/say', 'msg': {'data': 3}}, 'publish: data: give a text'),
        ({'op': 'publish', 'topic': '/say', 'msg': {'dat': ''}}, "publish: there is no field 'dat'"),
        ({'op': 'publish', 'topic': '/numbers', 'msg': {'data': ['x']}}, 'publish: data[0]: give a number'),
        (
            {'op': 'advertise', 'topic': '/say', 'type': 'std_msgs/Bool'},
            "'/say' has the type std_msgs/msg/String",
        ),
        ({'op': 'advertise', 'topic': '/x', 'type': 'no_msgs/No'}, "the type 'no_msgs/msg/No' is not known"),
        ({'op': 'subscribe', 'topic': '/nothing'}, "there is no topic '/nothing'"),
        ({'op': 'subscribe', 'topic': '/a b', 'type': 'std_msgs/Bool'}, 'Invalid topic name'),
        ({'op': 'cancel_action_goal', 'id': 'x'}, "no goal 'x' of this client runs"),
        ({'op': 'set_levl'}, "there is no operation 'set_levl'"),
        ({'no': 'op'}, "whose field 'op' names the operation"),
    ],
)
def test_what_does_not_fit_is_told_to_the_client(client: WebSocket, operation: Any, text: str) -> None:
    client.socket.send(json.dumps(operation))
    assert text in client.expect('status')['msg']
    assert client.call('/add', a=1, b=1)['result']  # the client goes on


@pytest.mark.parametrize('frame', ['{', '[' * 100_000, b'\xff', b'\xa1', 'null'])
def test_broken_frames_are_told_and_nothing_more(client: WebSocket, frame: str | bytes) -> None:
    client.socket.send(frame)
    assert client.expect('status')['level'] == 'error'


def test_operations_may_come_in_cbor_and_in_fragments(client: WebSocket, robot: Program) -> None:
    client.send('advertise', topic='/numbers', type='std_msgs/Float64MultiArray')
    client.send('advertise', topic='/say', type='std_msgs/String')
    client.socket.send(cbor2.dumps({'op': 'publish', 'topic': '/say', 'msg': {'data': 'cbor'}}))
    robot.expect('heard cbor')
    text = json.dumps({'op': 'publish', 'topic': '/say', 'msg': {'data': 'pieces'}})
    for number, part in enumerate((text[:20], text[20:])):
        client.send('fragment', id='f', num=number, total=2, data=part)
    robot.expect('heard pieces')


def test_typed_arrays_of_cbor_become_numbers(client: WebSocket) -> None:
    client.send('subscribe', topic='/floats', type='std_msgs/Float64MultiArray')
    client.send('advertise', topic='/floats', type='std_msgs/Float64MultiArray')
    data = cbor2.CBORTag(86, bytes(8) + b'\0\0\0\0\0\0\xf0?')
    client.socket.send(cbor2.dumps({'op': 'publish', 'topic': '/floats', 'msg': {'data': data}}))
    assert client.expect('publish')['msg']['data'] == [0.0, 1.0]


def test_status_messages_come_down_to_the_level_that_is_set(client: WebSocket) -> None:
    client.send('unadvertise', topic='/say')  # a warning, which is not told
    client.send('set_level', level='warning')
    client.send('unadvertise', topic='/other', id='u')
    assert client.expect('status') == {
        'op': 'status', 'id': 'u', 'level': 'warning', 'msg': "unadvertise: '/other' is not advertised",
    }  # fmt: skip


def test_parameters_are_read_and_set_by_rosapi(client: WebSocket) -> None:
    assert client.call('/rosapi/get_param', name='/robot:speed')['values'] == {'value': '0.5'}
    assert client.call('/rosapi/set_param', name='/robot:speed', value='0.75')['result']
    assert client.call('/rosapi/get_param', name='robot:speed')['values'] == {'value': '0.75'}
    assert client.call('/rosapi/has_param', name='/robot:no')['values'] == {'exists': False}
    refused = client.call('/rosapi/set_param', name='/robot:speed', value='"fast"')
    assert refused['result'] is False


def test_rosapi_shows_the_graph(client: WebSocket) -> None:
    assert '/say' in client.call('/rosapi/topics')['values']['topics']
    assert client.call('/rosapi/topic_type', topic='say')['values'] == {'type': 'std_msgs/msg/String'}
    assert '/add' in client.call('/rosapi/services')['values']['services']
    assert client.call('/rosapi/service_node', service='/add')['values'] == {'node': '/robot'}
    assert client.call('/rosapi/action_servers')['values'] == {'action_servers': ['/fibonacci']}
    details = client.call('/rosapi/message_details', type='geometry_msgs/Twist')['values']['typedefs']
    assert [each['type'] for each in details] == ['geometry_msgs/Twist', 'geometry_msgs/Vector3']


def test_allow_lists_limit_each_class_of_names(bridge: Start, robot: Program) -> None:
    options = ('--publish', '/cmd/*', '--subscribe', 're:/(say|numbers)', '--services', '/none')
    url = bridge('rosbridge', *options, '--actions', '/none', '--parameters', '/robot:s*').url
    with WebSocket(url) as client:
        client.send('publish', topic='/say', msg={'data': 'x'})
        assert '--publish' in client.expect('status')['msg']
        client.send('subscribe', topic='/picture')
        assert '--subscribe' in client.expect('status')['msg']
        client.send('subscribe', topic='/fibonacci/_action/feedback')
        assert '--actions' in client.expect('status')['msg']
        for service in ('/add', '/fibonacci/_action/send_goal', '/robot/set_parameters'):
            assert client.call(service)['result'] is False
        client.send('send_action_goal', id='g', **FIBONACCI)
        assert client.expect('action_result')['result'] is False
        assert client.call('/rosapi/get_param', name='/robot:speed')['result']
        assert client.call('/rosapi/get_param', name='/robot:use_sim_time')['result'] is False
        assert client.call('/rosapi/services')['values'] == {'services': []}


@pytest.mark.parametrize('topic', ['/parameter_events', '/robot/get_parameters/_service_event'])
def test_with_limited_parameters_no_topic_tells_of_the_others(
    bridge: Start, robot: Program, topic: str
) -> None:
    with WebSocket(bridge('rosbridge', '--parameters', '/robot:s*').url) as client:
        client.send('subscribe', topic=topic, type='rcl_interfaces/msg/ParameterEvent')
        assert '--parameters' in client.expect('status')['msg']
        assert '/parameter_events' not in client.call('/rosapi/topics')['values']['topics']


def test_a_bridge_that_is_read_only_sends_nothing(bridge: Start, robot: Program) -> None:
    with WebSocket(bridge('rosbridge', '--read-only').url) as client:
        client.send('publish', topic='/say', msg={'data': 'x'})
        assert '--read-only' in client.expect('status')['msg']
        assert client.call('/add', a=1)['result'] is False
        client.send('subscribe', topic='/robot_description')
        assert client.expect('publish')['msg'] == {'data': 'a robot'}


def test_a_token_is_asked_for(bridge: Start) -> None:
    url = bridge('rosbridge', '--token', 'secret').url
    assert url.endswith('/?token=secret')
    with WebSocket(url) as client:
        assert client.call('/rosapi/nodes')['result']
    bare = url.partition('?')[0]
    with WebSocket(bare, additional_headers={'Authorization': 'Bearer secret'}) as client:
        assert client.call('/rosapi/nodes')['result']
    for wrong in (bare, f'{bare}?token=guess'):
        with pytest.raises(InvalidStatus, match='403'), WebSocket(wrong):
            pytest.fail('it was let in')


def test_a_page_of_another_site_is_refused(bridge: Start) -> None:
    url = bridge('rosbridge', '--origin', 'https://app.example').url
    for origin in ('https://app.example', 'http://localhost:8000'):
        with WebSocket(url, origin=origin) as client:
            assert client.call('/rosapi/nodes')['result']
    for origin in ('https://evil.example', 'null', 'http://localhost.evil.example'):
        with pytest.raises(InvalidStatus, match='403'), WebSocket(url, origin=origin):
            pytest.fail('it was let in')
    with (
        pytest.raises(InvalidStatus, match='403'),
        WebSocket(url, additional_headers={'Host': 'evil.example'}),
    ):
        pytest.fail('it was let in')


def test_a_message_over_the_limit_is_refused(bridge: Start) -> None:
    with WebSocket(bridge('rosbridge', '--max-message-size', '1000').url) as client:
        client.send('publish', topic='/say', msg={'data': 'x' * 2000})
        with pytest.raises(ConnectionClosed, match='1009'):
            client.receive()


def test_more_clients_than_allowed_are_refused(bridge: Start) -> None:
    url = bridge('rosbridge', '--max-clients', '1').url
    with WebSocket(url), pytest.raises(InvalidStatus, match='503'), WebSocket(url):
        pytest.fail('it was let in')


@pytest.mark.slow
def test_a_client_that_reads_nothing_holds_up_nobody(bridge: Start) -> None:
    started = bridge('rosbridge', '--backlog', '1000000')
    with WebSocket(started.url, close_timeout=0.1) as slow, WebSocket(started.url) as quick:
        for client in (slow, quick):
            client.send('subscribe', topic='/much', type='std_msgs/String', id='s')
            client.call('/rosapi/get_time')
        quick.send('advertise', topic='/much', type='std_msgs/String')
        for number in range(200):  # 20 MB, of which the slow one reads nothing
            quick.send('publish', topic='/much', msg={'data': f'{number}{"x" * 100_000}'})
            assert quick.expect('publish')['msg']['data'].rstrip('x') == str(number)
    started.program.expect(r"read too slowly: it missed \d+ messages of '/much'")


def test_values_go_both_ways() -> None:
    from geometry_msgs.msg import PoseWithCovarianceStamped

    from goalwire.apps.bridge.rosbridge.values import from_values, to_cbor, to_json

    covariance = [math.pi] * 35 + [math.nan]
    values = {
        'header': {'stamp': {'secs': 3, 'nsecs': 4}, 'frame_id': 'map'},
        'pose': {'covariance': covariance},
    }
    message = from_values(PoseWithCovarianceStamped, values, lambda: None)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (3, 4)
    assert to_json(message)['pose']['covariance'][-2:] == [math.pi, None]
    again = from_values(PoseWithCovarianceStamped, to_json(message), lambda: None)
    assert to_json(again) == to_json(message)
    packed = cbor2.loads(cbor2.dumps(to_cbor(message)))
    assert to_json(from_values(PoseWithCovarianceStamped, packed, lambda: None)) == to_json(message)
