"""Types that are not installed where a command runs: a node that uses them describes them."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from apps.cli.conftest import PROGRAMS
from helpers.command_line import CommandLine, executable
from helpers.processes import Program
from helpers.wires import DDS

from goalwire.rosbag2.reader import Reader

DEFINITIONS = {
    'package.xml': '<package><name>away_interfaces</name></package>',
    'msg/Needle.msg': 'float64 angle\n',
    'msg/Gauge.msg': 'string name\nNeedle needle\nfloat32[3] scale\nuint8[<=4] marks\n',
    'srv/Tune.srv': 'float64 wanted\n---\nfloat64 reached\n',
    'action/Sweep.action': 'int32 sweeps\n---\nint32 sweeps\n---\nfloat32 part\n',
}


@pytest.fixture(scope='module')
def stranger(world: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Program]:
    folder = tmp_path_factory.mktemp('away') / 'away_interfaces'
    for name, text in DEFINITIONS.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    env = {**world, 'GOALWIRE_INTERFACE_PATH': str(folder)}
    with Program(PROGRAMS / 'stranger.py', env=env) as program:
        program.expect('^ready$')
        yield program


@pytest.fixture
def ros2(world: dict[str, str], stranger: Program, tmp_path: Path) -> CommandLine:
    return CommandLine(world, tmp_path)


def test_a_topic_is_echoed(ros2: CommandLine) -> None:
    shown = ros2.ok('topic', 'echo', '/gauge', '--once')
    assert shown.startswith('name: oil\nneedle:\n  angle: 0.5\nscale:\n- 0.0\n')


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
    """It is read where nobody knows the type."""
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


def _need_hashes_of_services(world: dict[str, str]) -> None:
    if world['RMW_IMPLEMENTATION'] == DDS:
        pytest.skip(
            'DDS shows the hashes of request and response, and no node describes a type without its hash'
        )


def test_a_type_that_no_node_uses_is_unknown(ros2: CommandLine) -> None:
    said = ros2.fails('topic', 'pub', '--once', '/other', 'away_interfaces/msg/Nothing', '{}', code=3)
    assert "there is no type 'away_interfaces/msg/Nothing' here" in said
