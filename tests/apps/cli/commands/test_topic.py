"""ros2 topic: its forms are ROS 2's."""

from __future__ import annotations

import json
import re
import signal
import subprocess

import pytest
from helpers.command_line import Begin, CommandLine, executable, on_dds_too
from helpers.processes import Program
from std_msgs.msg import Int32MultiArray, MultiArrayDimension, MultiArrayLayout

from goalwire.apps.cli.framework.expressions import Expression
from goalwire.apps.cli.framework.outcome import CommandError


def test_list_type_find(ros2: CommandLine) -> None:
    names = ros2.ok('topic', 'list').splitlines()
    assert names == sorted({'/lab/orders', '/lab/state', '/parameter_events', '/rosout'})
    assert '/lab/orders [std_msgs/msg/String]' in ros2.ok('topic', 'list', '-t').splitlines()
    assert '/lab/fibonacci/_action/feedback' in ros2.ok('topic', 'list', '-a').splitlines()
    verbose = ros2.ok('topic', 'list', '-v')
    assert verbose.startswith('Published topics:\n * /lab/state [std_msgs/msg/String] 1 publisher\n')
    assert '\n\nSubscribed topics:\n * /lab/orders [std_msgs/msg/String] 1 subscriber\n' in verbose
    assert ros2.ok('topic', 'type', 'lab/state') == 'std_msgs/msg/String\n'
    assert ros2.ok('topic', 'find', 'std_msgs/String') == '/lab/orders\n/lab/state\n'


INFO = """Type: std_msgs/msg/String

Publisher count: 1

Node name: workshop
Node namespace: /lab
Topic type: std_msgs/msg/String
Topic type hash: RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18
Endpoint type: PUBLISHER
GID: <gid>
QoS profile:
  Reliability: RELIABLE
  History (Depth): <history>
  Durability: TRANSIENT_LOCAL
  Lifespan: Infinite
  Deadline: Infinite
  Liveliness: AUTOMATIC
  Liveliness lease duration: Infinite

Subscription count: 0

"""


@on_dds_too
def test_info_is_what_ros_2_prints(ros2: CommandLine) -> None:
    assert ros2.ok('topic', 'info', '/lab/state') == (
        'Type: std_msgs/msg/String\nPublisher count: 1\nSubscription count: 0\n'
    )
    out = ros2.ok('topic', 'info', '/lab/state', '--verbose')
    out = re.sub('GID: [0-9a-f.]{47}', 'GID: <gid>', out)
    assert re.sub(r'Depth\): .*', 'Depth): <history>', out) == INFO


def test_echo_is_yaml_and_escaped(ros2: CommandLine, sensor: Program) -> None:
    assert ros2.ok('topic', 'echo', '/lab/state', '--once') == 'data: "ready \\e[31m"\n---\n'
    assert ros2.ok('topic', 'echo', '/text', '--once', '--field', 'data') == 'evil \\x1b[31m\nred\n---\n'
    pattern = (
        r'header:\n  stamp:\n    sec: \d+\n    nanosec: \d+\n  frame_id: lab\n'
        r'point:\n  x: \d+\.0\n  y: 0\.0\n  z: 0\.0\n---\n'
    )
    assert re.fullmatch(pattern, ros2.ok('topic', 'echo', '/point', '--once'))
    assert re.fullmatch(
        r'\d+,\d+,lab,\d+\.0,0\.0,0\.0\n', ros2.ok('topic', 'echo', '/point', '--once', '--csv')
    )
    assert re.fullmatch(r'\d+\.0\n---\n', ros2.ok('topic', 'echo', '/point', '--once', '--field', 'point.x'))
    assert ros2.ok('topic', 'echo', '/point', '--once', '--raw').startswith(("b'\\x00\\x01", 'b"\\x00\\x01'))
    message = json.loads(ros2.ok('topic', 'echo', '/point', '--once', '--json', '-i'))
    assert set(message) == {'info', 'message'}
    assert message['message']['header']['frame_id'] == 'lab'


NUMBER = r'(\d+|null)'
INFO_AS_YAML = (
    rf'publication_sequence_number: {NUMBER}\nreceived_timestamp: \d+\n'
    rf'reception_sequence_number: {NUMBER}\nsource_timestamp: \d+\n---\n'
)
INFO_OF_A_VALUE = (
    r"---Got new message, message info:---\n\{'source_timestamp': \d+, 'received_timestamp': \d+, "
    r"'publication_sequence_number': (\d+|None), 'reception_sequence_number': (\d+|None)\}\n"
    r'---Message data:---\n'
)


def test_echo_tells_when_messages_came_as_ros_2_does(ros2: CommandLine, sensor: Program) -> None:
    echo = ['topic', 'echo', '/point', '--once', '-i']
    assert re.fullmatch(
        INFO_AS_YAML + r'x: \d+\.0\ny: 0\.0\nz: 0\.0\n---\n', ros2.ok(*echo, '--field', 'point')
    )
    assert re.fullmatch(INFO_OF_A_VALUE + r'\d+\.0\n---\n', ros2.ok(*echo, '--field', 'point.x'))
    assert re.fullmatch(
        r'\d+,\d+,(\d+|None),(\d+|None),\d+\.0,0\.0,0\.0\n', ros2.ok(*echo, '--field', 'point', '--csv')
    )
    assert re.fullmatch(r'\d+\.0\n---\n', ros2.ok(*echo[:-1], '--field', 'point.x', '--csv'))


def test_echo_filters(ros2: CommandLine, sensor: Program) -> None:
    out = ros2.ok('topic', 'echo', 'point', '--once', '--filter', 'm.point.x % 10 == 3', '--csv')
    assert float(out.split(',')[3]) % 10 == 3
    out = ros2.ok('topic', 'echo', 'point', '--once', '--field', 'point.x', '--filter', 'm % 10 == 3')
    assert float(out.splitlines()[0]) % 10 == 3
    refused = ros2.fails('topic', 'echo', 'point', '--filter', '__import__("os")', code=4)
    assert 'is not allowed here' in refused
    wrong = ros2.fails('topic', 'echo', 'point', 'std_msgs/msg/String', '--once', '--timeout', '20', code=4)
    assert wrong == (
        "ros2: '/point' has the type geometry_msgs/msg/PointStamped, not std_msgs/msg/String; "
        'leave the type out'
    )
    assert "there is no 'w'" in ros2.fails('topic', 'echo', 'point', '--field', 'point.w', code=4)
    assert 'no message came' in ros2.fails('topic', 'echo', 'lab/orders', '--timeout', '0.2', code=5)


@on_dds_too
def test_hz_bw_and_delay_tell_what_comes(begin: Begin, sensor: Program) -> None:
    running = [begin('topic', verb, '/point') for verb in ('hz', 'bw', 'delay')]
    hz, bw, delay = running
    hz.expect(r'^average rate: \d+\.\d{3}$')
    hz.expect(r'^\tmin: \d+\.\d{3}s max: \d+\.\d{3}s std dev: \d+\.\d{5}s window: \d+$')
    bw.expect(r'^Subscribed to \[/point\]$')
    bw.expect(r'^\d+\.\d\d KB/s from \d+ messages$')
    bw.expect(r'^\tMessage size mean: 0.0\d KB min: 0.0\d KB max: 0.0\d KB$')
    delay.expect(r'^average delay: -?\d+\.\d{3}$')
    for each in running:
        each.send_signal(signal.SIGINT)
    assert [each.wait() for each in running] == [130] * 3


@pytest.mark.parametrize('command', [['echo', '/point'], ['hz', '/point'], ['bw', '/point']], ids=' '.join)
def test_whoever_reads_may_leave(world: dict[str, str], sensor: Program, command: list[str]) -> None:
    with subprocess.Popen(
        [executable(), 'topic', *command],
        env=world,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        assert running.stdout.readline()
        running.stdout.close()
        assert (running.wait(30), running.stderr.read()) == (141, '')


@on_dds_too
def test_pub_waits_publishes_and_leaves(ros2: CommandLine, workshop: Program) -> None:
    out = ros2.ok('topic', 'pub', '--once', 'lab/orders', 'std_msgs/msg/String', '{data: tea}')
    assert out.endswith("publisher: beginning loop\npublishing #1: std_msgs.msg.String(data='tea')\n\n")
    workshop.expect('^heard tea$')
    ros2.ok('topic', 'pub', '-t', '2', '-r', '20', 'lab/orders', 'data=more tea')
    workshop.expect('^heard more tea$')
    nobody = ['/nobody', 'std_msgs/String', 'data=x']
    told = ros2.fails('topic', 'pub', '-1', '--max-wait-time-secs', '0.3', *nobody, code=5)
    assert 'Expected 1 subscribers but only got 0 subscribers' in told
    told = ros2.fails('topic', 'pub', '-1', 'lab/orders', 'std_msgs/msg/Header', 'stamp: now', code=4)
    assert "'/lab/orders' has the type std_msgs/msg/String, not std_msgs/msg/Header" in told
    assert "there is no topic '/nobody'" in ros2.fails('topic', 'pub', '/nobody', 'data=x', code=3)
    told = ros2.fails('topic', 'pub', '-1', '/nobody', 'std_msgs/Int32', f'data={2**40}', code=4)
    assert told.startswith('ros2: std_msgs/msg/Int32: data: ')


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('m.data[0] + m.data[-1] == 5', True),
        ('len(m.data) > 3 or not m.data', False),
        ('"a" in m.layout.dim[0].label and 1 < m.data[1] <= 2', True),
        ('sum(m.data[:2]) == 3 if m.data else None', True),
        ('max(m.data) in [3, 4]', True),
    ],
)
def test_expressions_are_worked_out(text: str, value: object) -> None:
    layout = MultiArrayLayout(dim=[MultiArrayDimension(label='abc')])
    assert Expression(text)(Int32MultiArray(layout=layout, data=[1, 2, 4])) == value


@pytest.mark.parametrize(
    'text',
    [
        '__import__("os").system("true")',
        'm.__class__',
        'm.data.tolist()',
        '"a" * 10**9',
        '"%0999999999d" % 1',
        'open("/etc/passwd")',
        '[x for x in m.data]',
        '(lambda: 1)()',
        'm.nothing',
        '1 / 0',
        'm.data[9]',
        'import os',
        'f"{m}"',
        '(' * 500 + ')' * 500,
    ],
)
def test_expressions_do_nothing_else(text: str) -> None:
    with pytest.raises(CommandError, match='--filter'):
        Expression(text)(Int32MultiArray(data=[1]))
