"""Types that are not installed where a command runs: a node that uses them describes them."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.away import STRANGER, knowing_away
from helpers.command_line import Begin, CommandLine, executable, on_dds_too
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS

from goalwire.rosbag2.reader import Reader

_SILENT = ('--ros-args', '-r', '__ns:=/silent', '-p', 'start_type_description_service:=false')


@pytest.fixture(scope='module')
def away(world: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of programs that know the types."""
    return knowing_away(world, tmp_path_factory.mktemp('away'))


@pytest.fixture(scope='module')
def stranger(away: dict[str, str]) -> Iterator[Program]:
    with Program(STRANGER, env=away) as program:
        program.expect('^ready$')
        yield program


@pytest.fixture(scope='module')
def silent(away: dict[str, str]) -> Iterator[Program]:
    """The same under /silent; it does not describe its types, as no node does before ROS 2 Jazzy."""
    with Program(STRANGER, *_SILENT, env=away) as program:
        program.expect('^ready$')
        yield program


@pytest.fixture
def ros2(world: dict[str, str], stranger: Program, commands: ForkServer, tmp_path: Path) -> CommandLine:
    return CommandLine(world, tmp_path, commands)


@on_dds_too
def test_a_topic_is_echoed(ros2: CommandLine) -> None:
    shown = ros2.ok('topic', 'echo', '/gauge', '--once')
    assert shown.startswith('name: oil\nneedle:\n  angle: 0.5\nscale:\n- 0.0\n')


@pytest.mark.parametrize(
    ('verb', 'figure'),
    [('hz', r'^average rate: \d+\.\d{3}$'), ('bw', r'^\d+ B/s from \d+ messages$')],
    ids=['hz', 'bw'],
)
@pytest.mark.usefixtures('silent')
def test_messages_are_counted_without_a_definition(begin: Begin, verb: str, figure: str) -> None:
    begin('topic', verb, '/silent/gauge').expect(figure)


@pytest.mark.skipif(sys.platform == 'win32', reason='terminals of POSIX')
@pytest.mark.usefixtures('silent')
def test_top_shows_rates_without_a_definition(world: dict[str, str]) -> None:
    from helpers.screens import screen

    with screen(world, 'top', size=(130, 32)) as shown:
        shown.sees(r'\d+ nodes, \d+ topics')
        shown.press(b'2')
        shown.sees(r'/silent/gauge +\d+(\.\d+)? +\d+(\.\d+)? K?B +1 +')


def test_messages_are_counted_by_what_they_say(begin: Begin, stranger: Program) -> None:
    """For that they are decoded: the publisher's node describes them."""
    begin('topic', 'hz', '/gauge', '--filter', "m.name == 'oil'").expect(r'^average rate: \d+\.\d{3}$')


def test_a_delay_is_that_of_headers(ros2: CommandLine) -> None:
    """A node describes the type; so the command knows that it has none."""
    said = ros2.fails('topic', 'delay', '/gauge', code=4)
    assert "the messages of '/gauge' have no header" in said


def test_a_delay_needs_no_definition_if_the_header_is_the_first_field(
    world: dict[str, str], tmp_path: Path
) -> None:
    """In a world of its own: there is no node that describes the type."""
    alone = isolated_env(world['RMW_IMPLEMENTATION'])
    with ExitStack() as stack:
        node = stack.enter_context(Program(STRANGER, *_SILENT, env=knowing_away(alone, tmp_path)))
        node.expect('^ready$')
        command = ('topic', 'delay', '/silent/stamped')
        delay = stack.enter_context(Program(executable(), *command, env=alone))
        delay.expect("the type 'away_interfaces/msg/Stamped' is not known here")
        delay.expect(r'^average delay: 0\.\d{3}$')
        other = stack.enter_context(Program(executable(), 'topic', 'delay', '/silent/gauge', env=alone))
        other.expect("the messages of '/silent/gauge' have no header")


def test_a_message_is_published(ros2: CommandLine) -> None:
    published = ros2.ok(
        'topic', 'pub', '--once', '-w', '0', '/gauge', 'away_interfaces/msg/Gauge', '{name: water}'
    )
    assert "name='water'" in published


def test_a_service_is_called(ros2: CommandLine, world: dict[str, str]) -> None:
    _need_hashes_of_services(world)
    assert 'reached=3.0' in ros2.ok('service', 'call', '/tune', '{wanted: 1.5}')


def test_a_goal_is_sent(ros2: CommandLine, world: dict[str, str]) -> None:
    _need_hashes_of_services(world)
    sent = ros2.ok('action', 'send_goal', '/sweep', '{sweeps: 3}', '--feedback')
    assert 'part: 0.5' in sent
    assert 'sweeps: 3' in sent
    assert 'SUCCEEDED' in sent


def test_a_bag_has_the_definition(
    ros2: CommandLine, world: dict[str, str], stranger: Program, tmp_path: Path
) -> None:
    """The bag is read where nobody knows the type."""
    bag = tmp_path / 'bag'
    with Program(executable(), 'bag', 'record', '--topics', '/gauge', '-o', str(bag), env=world) as recorder:
        recorder.expect("recording '/gauge'")
        ros2.ok('topic', 'echo', '/gauge', '--once')  # by then one has come here, too
        recorder.send_signal(signal.SIGINT)
        assert recorder.wait() == 0
    with Reader(bag) as read:
        (topic,) = read.topics
        assert 'MSG: away_interfaces/Needle' in topic.schema.text
        _, gauge = next(iter(read.decoded()))
        assert (gauge.name, gauge.needle.angle) == ('oil', 0.5)


@on_dds_too
def test_calls_and_goals_of_a_bag_are_read_where_their_types_are_unknown(
    ros2: CommandLine, world: dict[str, str], stranger: Program, tmp_path: Path
) -> None:
    """The nodes tell the recorder what the types are, and the bag tells its readers."""
    _need_hashes_of_services(world)
    bag = tmp_path / 'bag'
    names = ('--services', '/tune', '--actions', '/sweep')
    with Program(executable(), 'bag', 'record', *names, '-o', str(bag), env=world) as recorder:
        recorder.expect_each(*(f"recording '{name}/_service_event'" for name in _SERVICES))
        ros2.ok('service', 'call', '/tune', '{wanted: 1.5}')
        ros2.ok('action', 'send_goal', '/sweep', '{sweeps: 3}', '--feedback')
        recorder.send_signal(signal.SIGINT)
        assert recorder.wait() == 0
    lines = [
        json.loads(line) for line in ros2.ok('bag', 'export', str(bag), '--format', 'jsonl').splitlines()
    ]
    said = {topic: [line['message'] for line in lines if line['topic'] == topic] for topic in _TOPICS}
    assert any(event['response'] == [{'reached': 3.0}] for event in said['/tune/_service_event'])
    requests = [event['request'] for event in said['/sweep/_action/send_goal/_service_event']]
    assert any(request and request[0]['goal'] == {'sweeps': 3} for request in requests)
    assert said['/sweep/_action/feedback'][0]['feedback'] == {'part': 0.5}


_SERVICES = ('/tune', '/sweep/_action/send_goal', '/sweep/_action/get_result')
_TOPICS = (*(f'{name}/_service_event' for name in _SERVICES), '/sweep/_action/feedback')


def _need_hashes_of_services(world: dict[str, str]) -> None:
    if world['RMW_IMPLEMENTATION'] == DDS:
        pytest.skip(
            'DDS shows the hashes of request and response, and no node describes a type without its hash'
        )


def test_a_type_that_no_node_uses_is_unknown(ros2: CommandLine) -> None:
    said = ros2.fails('topic', 'pub', '--once', '/other', 'away_interfaces/msg/Nothing', '{}', code=3)
    assert "there is no type 'away_interfaces/msg/Nothing' here" in said
