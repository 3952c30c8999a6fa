"""ros2 service: its forms are ROS 2's, and what it adds."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path

import pytest
from helpers.command_line import Begin, CommandLine, on_dds_too
from helpers.programs import Start

PARAMETER_SERVICES = [
    'describe_parameters',
    'get_parameter_types',
    'get_parameters',
    'get_type_description',
    'list_parameters',
    'set_parameters',
    'set_parameters_atomically',
]


def test_list_shows_what_is_not_hidden(ros2: CommandLine) -> None:
    names = ros2.ok('service', 'list').splitlines()
    own = ['/lab/add', '/lab/slow', '/lab/switch']
    assert names == sorted([*own, *(f'/lab/workshop/{each}' for each in PARAMETER_SERVICES)])


def test_list_shows_types_counts_and_hidden_ones(ros2: CommandLine) -> None:
    assert '/lab/add [example_interfaces/srv/AddTwoInts]' in ros2.ok('service', 'list', '-t').splitlines()
    assert ros2.ok('service', 'list', '--count') == '10\n'
    every = ros2.ok('service', 'list', '--include-hidden-services')
    assert every == ros2.ok('service', '--include-hidden-services', 'list')
    assert {'/lab/_secret', '/lab/fibonacci/_action/send_goal'} <= set(every.splitlines())


def test_list_as_json_is_a_document_a_line(ros2: CommandLine) -> None:
    documents = [json.loads(line) for line in ros2.ok('service', 'list', '--json').splitlines()]
    assert {'name': '/lab/add', 'types': ['example_interfaces/srv/AddTwoInts']} in documents


@on_dds_too
def test_type_find_and_info(ros2: CommandLine) -> None:
    assert ros2.ok('service', 'type', '/lab/add') == 'example_interfaces/srv/AddTwoInts\n'
    assert ros2.ok('service', 'type', 'lab/add/') == 'example_interfaces/srv/AddTwoInts\n'
    assert ros2.ok('service', 'find', 'std_srvs/Trigger') == '/lab/slow\n'
    assert ros2.ok('service', 'find', 'std_srvs/srv/SetBool', '-c') == '1\n'
    assert ros2.ok('service', 'info', '/lab/switch') == (
        'Type: std_srvs/srv/SetBool\nClients count: 1\nServices count: 0\n'
    )


@on_dds_too
def test_call_prints_request_and_response(ros2: CommandLine) -> None:
    expected = (
        'requester: making request: example_interfaces.srv.AddTwoInts_Request(a=2, b=3)\n'
        '\n'
        'response:\n'
        'example_interfaces.srv.AddTwoInts_Response(sum=5)\n'
        '\n'
    )
    assert (
        ros2.ok('service', 'call', '/lab/add', 'example_interfaces/srv/AddTwoInts', '{a: 2, b: 3}')
        == expected
    )


@pytest.mark.parametrize(
    'words',
    [
        ['example_interfaces/AddTwoInts', '{"a": 2, "b": 3}'],
        ['{a: 2, b: 3}'],
        ['a=2', 'b=3'],
        ['@{file}'],
        ['--stdin'],
    ],
)
def test_call_takes_values_in_many_forms(ros2: CommandLine, words: list[str], tmp_path: Path) -> None:
    file = tmp_path / 'request.yaml'
    file.write_text('a: 2\nb: 3\n', encoding='utf-8')
    given = [word.replace('{file}', str(file)) for word in words]
    out = ros2.ok('service', 'call', 'lab/add', *given, '--json', stdin='a: 2\nb: 3\n')
    answer = json.loads(out)
    assert (answer['request'], answer['response']) == ({'a': 2, 'b': 3}, {'sum': 5})
    assert answer['seconds'] > 0


def test_repeat_shows_latencies(ros2: CommandLine) -> None:
    lines = ros2.ok('service', 'call', '/lab/add', 'a=1', '--repeat', '20').splitlines()
    assert re.fullmatch(r"20 calls of '/lab/add' in [\d.]+ s: 20 answered, 0 failed", lines[0])
    assert re.fullmatch(r'min .* p50 .* p90 .* p95 .* p99 .* max .*', lines[1])
    assert sum(int(line.split()[-1]) for line in lines[2:]) == 20
    summary = json.loads(ros2.ok('service', 'call', '/lab/add', 'a=1', '--repeat', '5', '--json'))
    assert (summary['calls'], summary['answered'], summary['failed']) == (5, 5, 0)
    assert sum(each['calls'] for each in summary['histogram']) == 5


@pytest.mark.parametrize('value', ['"false"', 'flase', '3.7', '[true]', ''])
def test_a_value_that_is_no_bool_is_not_sent_as_one(ros2: CommandLine, value: str) -> None:
    told = ros2.fails('service', 'call', '/lab/switch', 'std_srvs/srv/SetBool', f'{{data: {value}}}', code=4)
    assert 'std_srvs/srv/SetBool: data: give true or false' in told


def test_what_is_wrong_is_said_in_one_line_with_a_code_of_its_own(ros2: CommandLine) -> None:
    assert ros2.fails('service', 'type', '/lab/ad', code=3) == (
        "ros2: there is no service '/lab/ad'; did you mean '/lab/add'? see: ros2 service list"
    )
    assert "did you mean 'example_interfaces/srv/AddTwoInts'" in ros2.fails(
        'service', 'call', '/lab/add', 'example_interfaces/srv/AddToInts', code=3
    )
    assert "has no field 'c'; its fields are: a, b" in ros2.fails(
        'service', 'call', '/lab/add', 'c=1', code=4
    )
    assert "a: give a whole number such as 3, not 'many' (int64)" in ros2.fails(
        'service', 'call', '/lab/add', 'a=many', code=4
    )
    assert 'is not YAML' in ros2.fails('service', 'call', '/lab/add', '{a: [}', code=4)
    assert "cannot read 'nowhere.yaml'" in ros2.fails('service', 'call', '/lab/add', '@nowhere.yaml', code=3)
    assert 'a: ' in ros2.fails('service', 'call', '/lab/add', f'a={2**70}', code=4)


def test_another_type_than_the_servers_is_told_at_once(ros2: CommandLine) -> None:
    told = ros2.fails('service', 'call', '/lab/add', 'std_srvs/srv/Trigger', '--timeout', '20', code=4)
    assert told == (
        "ros2: '/lab/add' has the type example_interfaces/srv/AddTwoInts, not std_srvs/srv/Trigger; "
        'leave the type out'
    )


def test_a_call_that_takes_too_long_ends_with_its_code(ros2: CommandLine) -> None:
    told = ros2.fails('service', 'call', '/lab/slow', '--timeout', '0.3', code=5)
    assert told.startswith("ros2: service '/lab/slow'")
    assert told.endswith('; give it more time, see --help')


def test_a_handler_that_fails_is_told(world: dict[str, str], start: Start) -> None:
    start('broken').expect('^ready$')
    told = CommandLine(world).fails('service', 'call', '/broken', '--timeout', '10', code=6)
    assert told.startswith("ros2: service '/broken'")
    assert told.endswith("; the server's log says why")


def test_a_service_that_nobody_serves_is_waited_for(ros2: CommandLine) -> None:
    ended = ros2('service', 'call', '/nobody', 'std_srvs/srv/Trigger', '--timeout', '0.5')
    assert (ended.code, ended.out) == (3, 'waiting for service to become available...\n')
    assert re.fullmatch(r'ros2: .* no server came .*; waited .* s; see: ros2 service list\n', ended.err)


def test_echo_says_what_to_switch_on_where_nobody_publishes_calls(ros2: CommandLine, begin: Begin) -> None:
    echo = begin('service', 'echo', '/lab/slow')
    echo.expect("^nobody publishes the calls of '/lab/slow': its server and clients have introspection off. ")
    echo.send_signal(signal.SIGINT)
    assert echo.wait() == 130


@on_dds_too
def test_echo_shows_the_steps_of_a_call(ros2: CommandLine, begin: Begin) -> None:
    echo = begin('service', 'echo', '/lab/add', '--qos-reliability', 'reliable', '--qos-depth', '50')
    while not re.search('^---$', echo.output, re.MULTILINE):  # until its subscription is known to the server
        ros2.ok('service', 'call', '/lab/add', 'a=40', 'b=2')
    echo.expect('^info:$')
    echo.expect('^  event_type: RE(QUEST|SPONSE)_(SENT|RECEIVED)$')
    echo.expect('^  client_gid:$')
    echo.expect('^---$')
    while not re.search('^response: \\[\\]$', echo.output, re.MULTILINE):
        ros2.ok('service', 'call', '/lab/add', 'a=40', 'b=2')
    assert 'request:\n- a: 40\n  b: 2\nresponse: []\n---' in echo.output


def test_a_server_that_goes_while_a_call_waits_is_told(begin: Begin, start: Start) -> None:
    lonely = start('lonely')
    lonely.expect('^ready$')
    call = begin('service', 'call', '/lonely', 'std_srvs/srv/Trigger')
    lonely.expect('^asked$')
    lonely.send_signal(signal.SIGINT)
    assert call.wait() == 6
    assert call.output.count('\n') == 2  # the request, an empty line, and why there is no response
    assert re.search("; (see: ros2 service info /lonely|the server's log says why)$", call.output.rstrip())
