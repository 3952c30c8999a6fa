"""`ros2 bag` as a process beside a program of rclpy."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path
from time import sleep

import pytest
from helpers.bags import contents, files_of, write_bag
from helpers.command_line import Begin, CommandLine
from helpers.processes import Program
from helpers.programs import programs_in, server_of_programs

from goalwire.rosbag2.reader import Reader

CDR = 'Serialization Format: cdr'
PROGRAMS = Path(__file__).parent / 'programs'


@pytest.fixture
def counter(world: dict[str, str]) -> Iterator[Program]:
    """The node of programs/counter.py, running."""
    with programs_in(world, PROGRAMS, server_of_programs()) as start:
        program = start('counter')
        program.expect('^ready$')
        yield program


def numbers_in(path: Path, topic: str = '/numbers') -> list[int]:
    with Reader(path) as bag:
        return [message.data for _, message in bag.decoded([topic])]


def assert_gapless(found: list[int]) -> None:
    assert len(found) > 3
    assert found == list(range(found[0], found[0] + len(found)))


@pytest.mark.slow
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_recording_ends_in_order(
    begin: Begin, counter: Program, ros2: CommandLine, tmp_path: Path, number: signal.Signals
) -> None:
    record = begin('bag', 'record', '-a', '-o', str(tmp_path / 'bag'), '--custom-data', 'robot=r2')
    for topic in ('/numbers', '/fast', '/word'):
        record.expect(f"recording '{topic}'")
    sleep(0.3)
    record.send_signal(number)
    record.expect('messages of')
    assert record.wait() == 0
    assert_gapless(numbers_in(tmp_path / 'bag'))
    assert_gapless(numbers_in(tmp_path / 'bag', '/fast'))
    with Reader(tmp_path / 'bag') as bag:
        assert bag.counts['/word'] == 1
        assert ('robot', 'r2') in bag.facts.custom_data
        assert list(bag.check()) == []


@pytest.mark.slow
def test_a_killed_recorder_leaves_a_bag_that_opens_everywhere(
    begin: Begin, counter: Program, tmp_path: Path
) -> None:
    record = begin('bag', 'record', '/numbers', '-o', str(tmp_path / 'bag'))
    record.expect("recording '/numbers'")
    sleep(1.2)  # twice as long as a flush waits
    record.kill()
    assert_gapless(numbers_in(tmp_path / 'bag'))
    rosbags = pytest.importorskip('rosbags.rosbag2')
    with rosbags.Reader(tmp_path / 'bag') as bag:
        assert sum(1 for _ in bag.messages()) == len(contents(tmp_path / 'bag'))


@pytest.mark.slow
def test_messages_are_compressed_while_they_are_recorded(
    begin: Begin, counter: Program, ros2: CommandLine, tmp_path: Path
) -> None:
    flags = ['-s', 'sqlite3', '--compression-mode', 'message', '--compression-format', 'zstd']
    record = begin('bag', 'record', '/numbers', '-o', str(tmp_path / 'bag'), *flags)
    record.expect("recording '/numbers'")
    sleep(0.3)
    record.send_signal(signal.SIGINT)
    assert record.wait() == 0
    assert_gapless(numbers_in(tmp_path / 'bag'))
    rosbags = pytest.importorskip('rosbags.rosbag2')
    with rosbags.Reader(tmp_path / 'bag') as bag:
        assert [bytes(data) for _, _, data in bag.messages()] == [
            data for _, _, data in contents(tmp_path / 'bag')
        ]
    assert 'every byte is there' in ros2.ok('bag', 'check', 'bag')
    ended = ros2('bag', 'play', 'bag', '--rate', '10')
    assert ended.err.splitlines()[-1] == f'{len(contents(tmp_path / "bag"))} messages were published'
    (tmp_path / 'copy.yaml').write_text(
        'output_bags: [{uri: copy, all: true, storage_id: sqlite3, compression_mode: message}]'
    )
    ros2.ok('bag', 'convert', '-i', 'bag', '-o', 'copy.yaml')
    assert contents(tmp_path / 'copy') == contents(tmp_path / 'bag')


@pytest.mark.slow
def test_a_bag_is_played_to_its_end(ros2: CommandLine, tmp_path: Path) -> None:
    write_bag(tmp_path / 'bag')
    ended = ros2('bag', 'play', 'bag', '--rate', '10', '--wait-for-all-acked', '100')
    assert (ended.code, ended.out) == (0, '')
    assert ended.err.splitlines() == ["playing 'bag': 2 topics", '110 messages were published']
    ended = ros2('bag', 'play', 'bag', '--rate', '10', '--topics', '/words')
    assert ended.err.splitlines() == ["playing 'bag': 1 topics", '10 messages were published']
    assert 'nothing of' in ros2.fails('bag', 'play', 'bag', '--topics', '/none', code=1)
    assert 'OLD:=NEW' in ros2.fails('bag', 'play', 'bag', '-m', '/words', code=2)


@pytest.mark.slow
def test_a_burst_pauses_after_its_messages(ros2: CommandLine, begin: Begin, tmp_path: Path) -> None:
    write_bag(tmp_path / 'bag')
    burst = begin('bag', 'burst', str(tmp_path / 'bag'), '-n', '30')
    burst.expect('bursting')
    assert 'actually_burst=5' in ros2.ok(
        'service', 'call', '/rosbag2_player/burst', 'rosbag2_interfaces/srv/Burst', 'num_messages: 5'
    )
    ros2.ok('service', 'call', '/rosbag2_player/stop', 'rosbag2_interfaces/srv/Stop')
    burst.expect('35 messages were published')
    assert burst.wait() == 0


def test_info_tells_what_is_in_a_bag(ros2: CommandLine, tmp_path: Path) -> None:
    write_bag(tmp_path / 'bag')
    told = ros2.ok('bag', 'info', 'bag', TZ='UTC')
    assert told.splitlines()[1:] == [
        'Files:             bag_0.mcap',
        f'Bag size:          {files_of(tmp_path / "bag")[0].stat().st_size / 1024:.1f} KiB',
        'Storage id:        mcap',
        'ROS Distro:        rolling',
        'Duration:          0.099000000s',
        'Start:             Nov 14 2023 22:13:20.000000000 (1700000000.000000000)',
        'End:               Nov 14 2023 22:13:20.099000000 (1700000000.099000000)',
        'Messages:          110',
        f'Topic information: Topic: /numbers | Type: std_msgs/msg/Int32 | Count: 100 | {CDR}',
        f'                   Topic: /words | Type: std_msgs/msg/String | Count: 10 | {CDR}',
        'Services:          0',
    ]
    assert ros2.ok('bag', 'info', 'bag', '-t').split() == ['/numbers', '/words']
    assert 'Size Contribution: 800 B' in ros2.ok('bag', 'info', 'bag', '-v')
    found = json.loads(ros2.ok('bag', 'info', '--json', 'bag/bag_0.mcap'))
    assert [topic['messages'] for topic in found['topics']] == [100, 10]


def test_storages_are_listed(ros2: CommandLine) -> None:
    assert ros2.ok('bag', 'list', 'storage').split() == ['mcap', 'sqlite3']


@pytest.mark.parametrize(
    ('arguments', 'code', 'told'),
    [
        ('info nowhere', 3, "there is no bag 'nowhere'"),
        ('record', 2, 'nothing is chosen; name topics, or give -a'),
        ('record -a --max-bag-files 3', 2, 'give -b or -d as well'),
        ('record -a --compression-mode message', 2, 'give --storage sqlite3 as well'),
        ('record -e (', 2, 'not a regular expression'),
        ('record -a -o there', 1, 'exists already'),
        ('record -a --qos-profile-overrides-path nowhere.yaml', 3, 'nowhere.yaml'),
    ],
)
def test_mistakes_are_told_in_one_line(
    ros2: CommandLine, tmp_path: Path, arguments: str, code: int, told: str
) -> None:
    (tmp_path / 'there').mkdir()
    assert told in ros2.fails('bag', *arguments.split(), code=code)
    assert [each.name for each in tmp_path.iterdir()] == ['there']


def test_without_the_extra_one_line_says_what_to_install(ros2: CommandLine, tmp_path: Path) -> None:
    """A module that cannot be imported stands for one that is not installed."""
    hidden = tmp_path / 'hidden' / 'mcap'
    hidden.mkdir(parents=True)
    (hidden / '__init__.py').write_text("raise ModuleNotFoundError(\"No module named 'mcap'\", name='mcap')")
    unforked = CommandLine(ros2.env, ros2.cwd)  # a new interpreter looks into PYTHONPATH
    told = unforked.fails('bag', 'record', '-a', code=1, PYTHONPATH=str(hidden.parent))
    assert told == "ros2: bags need the package 'mcap'; run: pip install 'goalwire[bag]'"
