"""Bridges with an identity: each client signs in by name, and may do what the policy allows to it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from helpers.bridge import FoxgloveClient, WebSocket, start_bridge
from helpers.isolation import isolated_env
from helpers.patience import wait_for
from helpers.processes import Program
from websockets.exceptions import ConnectionClosed, InvalidStatus

from goalwire.security import audit
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.security.sign_in.tokens import delete_tokens, make_token

PROGRAMS = Path(__file__).with_name('programs')
ALL = ''.join(f'{verb.value} = ["/**"]\n' for verb in Verb)
POLICY = f"""\
[roles.robot]
{ALL}
[roles.tablet]
call = ["/add"]
send = ["/fibonacci"]
publish = ["/say"]
subscribe = ["/numbers"]
read = ["/robot"]
[identities]
robby = ["robot"]
bridge = ["robot"]
tablet = ["tablet"]
lamp = []
"""


@pytest.fixture(scope='module')
def keystore(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    made = Keystore.create(tmp_path_factory.mktemp('site') / 'keys')
    made.add('robby', 'robot', ())
    made.add('bridge', 'program', ())
    made.policy_path.write_text(POLICY)
    return made


@pytest.fixture(scope='module')
def urls(keystore: Keystore) -> Iterator[dict[str, str]]:
    """The addresses of both bridges beside a robot."""
    world = isolated_env('rmw_zenoh_cpp')
    with ExitStack() as stack:
        own = {**world, 'GOALWIRE_SECURITY': f'{keystore.path}:robby'}
        robot = stack.enter_context(Program(PROGRAMS / 'robot.py', env=own))
        robot.expect('ready')
        own = {**world, 'GOALWIRE_SECURITY': f'{keystore.path}:bridge'}
        yield {protocol: start_bridge(stack, own, protocol).url for protocol in ('rosbridge', 'foxglove')}


@pytest.fixture
def tablet(urls: dict[str, str], keystore: Keystore) -> Iterator[WebSocket]:
    with WebSocket(f'{urls["rosbridge"]}?token={make_token(keystore.path, "tablet")}') as client:
        yield client


def _entries(keystore: Keystore) -> list[dict[str, str]]:
    return list(audit.read(audit.log_path(keystore.path, 'bridge')))


@pytest.mark.parametrize('protocol', ['rosbridge', 'foxglove'])
@pytest.mark.parametrize('query', ['', '?token=guessed'])
def test_a_client_without_a_token_that_counts_is_refused(
    urls: dict[str, str], protocol: str, query: str
) -> None:
    client: type[WebSocket | FoxgloveClient] = WebSocket if protocol == 'rosbridge' else FoxgloveClient
    with pytest.raises(InvalidStatus) as caught, client(urls[protocol] + query):
        pass
    assert caught.value.response.status_code == 403


def test_a_client_may_what_its_name_may(tablet: WebSocket, keystore: Keystore) -> None:
    assert tablet.call('/add', a=1, b=2)['values'] == {'sum': 3}
    refused = tablet.call('/robot/set_parameters', parameters=[])
    assert refused['result'] is False
    assert "none of the roles of 'tablet' may set '/robot'" in refused['values']
    tablet.send('publish', topic='/elsewhere', type='std_msgs/String', msg={'data': 'x'})
    assert "may publish '/elsewhere'" in tablet.expect('status')['msg']
    tablet.send('subscribe', topic='/picture', type='sensor_msgs/Image')
    assert "may subscribe '/picture'" in tablet.expect('status')['msg']
    shown = tablet.call('/rosapi/topics')['values']['topics']
    assert '/numbers' in shown
    assert '/picture' not in shown
    assert tablet.call('/rosapi/nodes')['values'] == {'nodes': []}


def test_goals_are_in_the_log_under_the_name_of_the_client(tablet: WebSocket, keystore: Keystore) -> None:
    tablet.send(
        'send_action_goal',
        id='1',
        action='/fibonacci',
        action_type='example_interfaces/action/Fibonacci',
        args={'order': 3},
    )
    assert tablet.expect('action_result')['result'] is True
    wanted = {'who': 'tablet', 'act': 'send', 'key': '/fibonacci', 'outcome': 'moves', 'via': 'bridge'}
    wait_for(lambda: any(wanted.items() <= each.items() for each in _entries(keystore)), 'its entry')


def test_foxglove_shows_what_the_client_may_use(urls: dict[str, str], keystore: Keystore) -> None:
    token = make_token(keystore.path, 'tablet')
    with FoxgloveClient(f'{urls["foxglove"]}?token={token}') as client:
        assert client.channel('/numbers')['topic'] == '/numbers'
        of_goals = {'/fibonacci/_action/feedback', '/fibonacci/_action/status'}
        assert client.channels.keys() <= {'/numbers', '/say', *of_goals}


def _closed(client: Any) -> str:
    with pytest.raises(ConnectionClosed) as caught:
        client.expect('the end')
    assert caught.value.rcvd is not None
    return caught.value.rcvd.reason


def test_a_client_is_disconnected_when_its_token_is_deleted(urls: dict[str, str], keystore: Keystore) -> None:
    with WebSocket(f'{urls["rosbridge"]}?token={make_token(keystore.path, "lamp")}') as client:
        client.send('subscribe', topic='/numbers', type='std_msgs/Float64MultiArray')
        client.expect('status')
        delete_tokens(keystore.path, 'lamp')
        assert _closed(client) == "the token of 'lamp' was deleted"
