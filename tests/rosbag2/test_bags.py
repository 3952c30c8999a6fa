"""A reader reads what a writer writes: every storage, splits, times, topics, and bags that nobody closed."""

from __future__ import annotations

import os
import shutil
import signal
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from random import Random
from typing import Any

import pytest
from helpers.bags import (
    LATCHED,
    MS,
    NUMBERS,
    START,
    WORDS,
    add_topics,
    contents,
    expected,
    files_of,
    messages_of,
    number,
    put,
    word,
    write_bag,
)

from goalwire.apps.bag.rewriting import reindex
from goalwire.errors import BagError, InterfaceError
from goalwire.idl import type_hash
from goalwire.rosbag2.mcap_reader import McapReader
from goalwire.rosbag2.metadata import read_metadata
from goalwire.rosbag2.model import Message, Schema, Topic
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.types import class_of
from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import QoS

KINDS: dict[str, dict[str, Any]] = {
    'mcap': {},
    'zstd_fast': {'preset': 'zstd_fast'},
    'zstd_small': {'preset': 'zstd_small'},
    'packed files': {'compress_files': True},
    'sqlite3': {'storage': 'sqlite3'},
    'packed sqlite3': {'storage': 'sqlite3', 'compress_files': True},
    'packed messages': {'storage': 'sqlite3', 'compress_messages': True},
    'many files': {'max_bytes': 1000},
}


@pytest.mark.parametrize('kind', KINDS)
def test_what_is_written_is_read(tmp_path: Path, kind: str) -> None:
    path = write_bag(tmp_path / 'bag', **KINDS[kind])
    assert contents(path) == expected()
    with Reader(path) as bag:
        assert bag.counts == {NUMBERS: 100, WORDS: 10}
        assert (bag.start, bag.end) == (START, START + 99 * MS)
        assert bag.problems == []
        assert list(bag.check()) == []
        topics = {topic.name: topic for topic in bag.topics}
        assert topics[NUMBERS].type_name == 'std_msgs/msg/Int32'
        assert topics[NUMBERS].type_hash == type_hash('std_msgs/msg/Int32')
        assert topics[NUMBERS].schema.text.strip().endswith('int32 data')
        assert topics[WORDS].qos == (LATCHED.stated(),)
    facts = read_metadata(str(path / 'metadata.yaml'))
    assert (facts.count, facts.version) == (110, 9)
    assert sum(file.count for file in facts.files) == 110


@pytest.mark.parametrize('kind', KINDS)
def test_a_writer_counts_each_message_once_open_or_closed(tmp_path: Path, kind: str) -> None:
    with Writer(tmp_path / 'bag', **KINDS[kind]) as bag:
        add_topics(bag)
        for value in range(10):
            put(bag, value)
        assert bag.count == 11
    assert bag.count == 11


def test_an_empty_bag_is_read(tmp_path: Path) -> None:
    assert contents(write_bag(tmp_path / 'bag', 0)) == []


def test_times_of_sending_and_numbers_are_kept(tmp_path: Path) -> None:
    first = messages_of(write_bag(tmp_path / 'bag'))[0]
    assert (first.sent, first.sequence) == (START - 5, 1)


def test_topics_and_times_choose_messages(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', max_bytes=500)
    with Reader(path) as bag:
        assert [message.time for message in bag.messages([WORDS])] == [
            START + value * MS + 1 for value in range(0, 100, 10)
        ]
        some = list(bag.messages(start=START + 20 * MS, stop=START + 30 * MS))
    assert [each for each in expected() if START + 20 * MS <= each[1] < START + 30 * MS] == [
        (each.topic, each.time, each.data) for each in some
    ]


def test_messages_come_in_the_order_of_their_times(tmp_path: Path) -> None:
    times = list(range(500))
    Random(3).shuffle(times)
    with Writer(tmp_path / 'bag', max_bytes=4000) as bag:
        add_topics(bag)
        for value in times:
            bag.write(NUMBERS, number(value), START + value)
    assert [data for _, _, data in contents(tmp_path / 'bag')] == [number(value) for value in range(500)]


def test_messages_of_one_time_stay_in_their_order(tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag') as bag:
        add_topics(bag)
        for value in range(50):
            bag.write(NUMBERS, number(value), START)
    assert [data for _, _, data in contents(tmp_path / 'bag')] == [number(value) for value in range(50)]


def test_large_messages_are_chunks_of_their_own(tmp_path: Path) -> None:
    image = os.urandom(3_000_000)
    with Writer(tmp_path / 'bag', preset='zstd_fast') as bag:
        bag.add_topic('/image', 'sensor_msgs/msg/Image')
        for value in range(3):
            bag.write('/image', image, START + value)
    assert [message.data for message in messages_of(tmp_path / 'bag')] == [image] * 3


def test_splits_lose_nothing_and_begin_with_the_heads(tmp_path: Path) -> None:
    told: list[tuple[str, str]] = []
    with Writer(tmp_path / 'bag', max_duration=0.02, on_split=lambda *files: told.append(files)) as bag:
        add_topics(bag)
        bag.heads = lambda time: [Message(WORDS, time, b'head', 7)]
        for value in range(100):
            put(bag, value)
    files = files_of(tmp_path / 'bag')
    assert [file.name for file in files] == [f'bag_{n}.mcap' for n in range(5)]
    assert [(Path(closed).name, Path(opened).name) for closed, opened in told] == [
        (f'bag_{n}.mcap', f'bag_{n + 1}.mcap') for n in range(4)
    ]
    found = contents(tmp_path / 'bag')
    heads = [each for each in found if each[2] == b'head']
    assert [time for _, time, _ in heads] == [START + value * MS for value in (20, 40, 60, 80)]
    assert [each for each in found if each[2] != b'head'] == expected()
    for file in files[1:]:
        assert messages_of(file)[0].data in {b'head', messages_of(file)[1].data}


def test_the_oldest_files_are_removed(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', max_duration=0.02, max_files=2)
    assert [file.name for file in files_of(path)] == ['bag_3.mcap', 'bag_4.mcap']
    assert contents(path) == [each for each in expected() if each[1] >= START + 60 * MS]
    assert read_metadata(str(path / 'metadata.yaml')).count == 44


def test_a_bag_without_metadata_is_read(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', max_bytes=300)
    (path / 'metadata.yaml').unlink()
    assert len(files_of(path)) > 10  # bag_10 comes after bag_9
    assert contents(path) == expected()


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_bag_is_whole_after_each_flush(tmp_path: Path, storage: str) -> None:
    with Writer(tmp_path / 'bag', storage=storage) as bag:
        add_topics(bag)
        for value in range(60):
            put(bag, value)
            if value in {0, 20, 49}:
                bag.flush()
                copy = tmp_path / f'copy_{value}'
                shutil.copytree(tmp_path / 'bag', copy)
                assert contents(copy) == expected(value + 1)
                with Reader(copy) as read:
                    assert read.problems == []
                assert read_metadata(str(copy / 'metadata.yaml')).count == read.facts.count


def test_a_file_cut_anywhere_gives_all_before_the_cut(tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag') as bag:
        add_topics(bag)
        for value in range(100):
            put(bag, value)
            if value % 5 == 4:
                bag.flush()  # a chunk each
    whole = files_of(tmp_path / 'bag')[0].read_bytes()
    file = tmp_path / 'cut.mcap'
    found = []
    for size in range(30, len(whole), 101):
        file.write_bytes(whole[:size])
        with McapReader(str(file)) as cut:
            messages = list(cut.messages())
            assert cut.problem
        assert [(m.topic, m.time, m.data) for m in messages] == expected()[: len(messages)]
        found.append(len(messages))
    assert found == sorted(found)
    assert found[-1] == 110


PACKED: dict[str, Any] = KINDS['packed messages']


def test_packed_messages_are_told_from_plain_ones_by_each_file_alone(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', **PACKED)
    (path / 'metadata.yaml').unlink()
    assert contents(path / 'bag_0.db3') == expected()
    with reindex(str(path)) as bag:
        assert bag.facts.compression_mode == 'message'
    assert contents(path) == expected()


def test_packed_messages_take_less_room(tmp_path: Path) -> None:
    sizes = {}
    for name, options in (('plain', {'storage': 'sqlite3'}), ('packed', PACKED)):
        with Writer(tmp_path / name, **options) as bag:
            add_topics(bag)
            bag.write(WORDS, word('to and fro ' * 10_000), START)
        sizes[name] = (tmp_path / name / f'{name}_0.db3').stat().st_size
    assert sizes['packed'] < sizes['plain'] / 2


def test_heads_are_packed_as_other_messages_are(tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag', max_duration=0.05, **PACKED) as bag:
        add_topics(bag)
        bag.heads = lambda time: [Message(WORDS, time, b'head', 7)]
        for value in range(100):
            put(bag, value)
    assert [data for _, _, data in contents(tmp_path / 'bag')].count(b'head') == 1


def test_a_message_that_cannot_be_unpacked_is_told_and_the_rest_is_rescued(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', **PACKED)
    with closing(sqlite3.connect(path / 'bag_0.db3')) as database:
        database.execute("UPDATE messages SET data = x'28b52ffd' WHERE id = 50")
        database.commit()
    with Reader(path) as bag:
        assert list(bag.check()) == ['bag_0.db3: 1 messages cannot be unpacked']
        assert len(list(bag.rescued())) == 109
        with pytest.raises(BagError, match="a message of '/numbers' cannot be unpacked"):
            list(bag.messages())


@pytest.mark.parametrize(
    ('options', 'told'),
    [
        ({'storage': 'mcap'}, 'the storage mcap cannot compress messages one by one'),
        ({'storage': 'sqlite3', 'compress_files': True}, 'not both'),
    ],
)
def test_messages_are_packed_where_rosbag2_reads_them(
    tmp_path: Path, options: dict[str, Any], told: str
) -> None:
    with pytest.raises(BagError, match=told):
        Writer(tmp_path / 'bag', compress_messages=True, **options)
    assert not (tmp_path / 'bag').exists()


def test_a_broken_chunk_is_told_and_the_rest_is_rescued(tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag') as bag:
        add_topics(bag)
        for value in range(100):
            put(bag, value)
            if value % 20 == 19:
                bag.flush()
    file = files_of(tmp_path / 'bag')[0]
    data = bytearray(file.read_bytes())
    at = data.index(number(45), 0)  # in the third chunk
    data[at + 5] ^= 0xFF
    file.write_bytes(data)
    with Reader(tmp_path / 'bag') as bag_read:
        problems = list(bag_read.check())
        assert any('crc' in problem for problem in problems)
        with pytest.raises(BagError, match='ros2 bag repair'):
            list(bag_read.messages())
        left = [(m.topic, m.time, m.data) for m in bag_read.rescued()]
    assert left == [each for each in expected() if not START + 40 * MS <= each[1] < START + 60 * MS]


@pytest.mark.parametrize('break_it', [lambda d: d[:-40] + b'x' * 40, lambda d: d[:-60] + bytes(52) + d[-8:]])
def test_a_file_with_a_broken_end_is_read(tmp_path: Path, break_it: Callable[[bytes], bytes]) -> None:
    file = files_of(write_bag(tmp_path / 'bag'))[0]
    file.write_bytes(break_it(file.read_bytes()))
    with McapReader(str(file)) as cut:
        assert cut.problem
        assert [(m.topic, m.time, m.data) for m in cut.messages()] == expected()


@pytest.fixture
def limit_files() -> Iterator[Callable[[int], None]]:
    """Make writing beyond a size fail, as it does on a full disk."""
    resource = pytest.importorskip('resource')
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def _fill(bag: Writer) -> None:
    for value in range(1_000_000):
        bag.write(NUMBERS, number(value) + bytes(1000), START + value)


def test_a_file_with_any_broken_byte_is_read_or_refused(tmp_path: Path) -> None:
    (file,) = files_of(write_bag(tmp_path / 'bag'))
    whole = file.read_bytes()
    random = Random(1)
    outcomes = set()
    for _ in range(300):
        broken = bytearray(whole)
        for _ in range(random.choice([1, 3, 20])):
            broken[random.randrange(len(whole) // 2, len(whole))] = random.randrange(256)
        file.write_bytes(broken)
        try:
            outcomes.add(len(contents(file)))
        except BagError:
            outcomes.add(-1)
    assert outcomes >= {-1, 110}
    assert max(outcomes) == 110, 'no message is read twice'


def test_a_sqlite3_file_whose_columns_are_broken_is_refused(tmp_path: Path) -> None:
    (file,) = write_bag(tmp_path / 'bag', storage='sqlite3').glob('*.db3')
    file.write_bytes(file.read_bytes().replace(b'serialization_format TEXT', b'serialization_forma\xdd TEXT'))
    with pytest.raises(BagError, match='cannot be read as a sqlite3 bag'):
        Reader(file)


def test_a_file_whose_metadata_are_broken_is_read_without_its_summary(tmp_path: Path) -> None:
    (file,) = files_of(write_bag(tmp_path / 'bag'))
    whole = file.read_bytes()
    at = whole.rindex(b'serialized_metadata') + len(b'serialized_metadata') + 5
    file.write_bytes(whole[:at] + b'\xdd' + whole[at + 1 :])
    assert contents(file) == expected()
    with Reader(file) as bag:
        assert bag.counts == {NUMBERS: 100, WORDS: 10}
        (problem,) = bag.problems
        assert 'its summary is broken' in problem


def test_a_full_disk_costs_what_has_no_room(tmp_path: Path, limit_files: Callable[[int], None]) -> None:
    with Writer(tmp_path / 'bag') as bag:
        add_topics(bag)
        limit_files(3_000_000)
        with pytest.raises(BagError, match='File too large'):
            _fill(bag)
    found = contents(tmp_path / 'bag')
    assert len(found) > 1900
    assert [time for _, time, _ in found] == list(range(START, START + len(found)))
    with McapReader(str(files_of(tmp_path / 'bag')[0])) as file:
        assert file.problem == ''


def test_chunks_make_room_for_the_end(tmp_path: Path, limit_files: Callable[[int], None]) -> None:
    bag = Writer(tmp_path / 'bag')
    add_topics(bag)
    for value in range(3000):
        bag.write(NUMBERS, number(value) + bytes(1000), START + value)
    bag.flush()
    with McapReader(bag.file) as file:
        assert file.count == 3000
    bag.write(NUMBERS, number(3000), START + 3000)
    limit_files(Path(bag.file).stat().st_size - 100)
    with pytest.raises(BagError, match='File too large'):
        bag.close()
    with McapReader(bag.file) as file:
        assert file.problem == ''
        assert 1000 < file.count < 2500  # two chunks of three
        assert len(list(file.messages())) == file.count


def test_what_cannot_be_is_refused(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', 1)
    with pytest.raises(BagError, match='exists already'):
        Writer(path)
    with pytest.raises(BagError, match='no storage'):
        Writer(tmp_path / 'other', storage='rosbag1')
    with pytest.raises(BagError, match='no preset'):
        Writer(tmp_path / 'other', preset='fastest')
    with pytest.raises(FileNotFoundError, match='no bag'):
        Reader(tmp_path / 'nowhere')
    (tmp_path / 'empty').mkdir()
    with pytest.raises(BagError, match='no bag is there'):
        Reader(tmp_path / 'empty')
    (tmp_path / 'text.mcap').write_text('no bag')
    with pytest.raises(BagError, match='not an MCAP file'):
        Reader(tmp_path / 'text.mcap')
    (tmp_path / 'text.db3').write_text('no bag, but long enough for a header of sqlite3' * 10)
    with pytest.raises(BagError, match='sqlite3'):
        Reader(tmp_path / 'text.db3')
    files_of(path)[0].unlink()
    with pytest.raises(BagError, match='is missing'):
        Reader(path)
    with Writer(tmp_path / 'new') as bag, pytest.raises(BagError, match='add_topic'):
        bag.write('/unknown', b'', 0)


def test_unknown_types_are_recorded_and_defined_by_the_bag(tmp_path: Path) -> None:
    text = 'bag_only_msgs/Inner inner\nint8 x\n' + '=' * 80 + '\nMSG: bag_only_msgs/Inner\nint32 y\n'
    with Writer(tmp_path / 'bag') as bag:
        bag.add_topic('/here', 'bag_only_msgs/msg/Outer', schema=Schema('ros2msg', text))
        bag.add_topic('/nowhere', 'nowhere_msgs/msg/None')
        bag.write('/here', b'\0\1\0\0' + (7).to_bytes(4, 'little') + b'\3', START)
        bag.write('/nowhere', b'\0\1\0\0\1', START + 1)
    with Reader(tmp_path / 'bag') as read:
        (_, message), *_ = read.decoded(['/here'])
        assert (message.inner.y, message.x) == (7, 3)
        with pytest.raises(InterfaceError):
            list(read.decoded(['/nowhere']))
        assert [m.data for m in read.messages(['/nowhere'])] == [b'\0\1\0\0\1']


@pytest.mark.parametrize('name', ['std_msgs/csg/Word', 'std_msgs/Word', 'Word', 'a/b/c/Word'])
def test_a_type_whose_name_is_broken_is_told(name: str) -> None:
    topic = Topic(WORDS, name, schema=Schema('ros2msg', 'string data'))
    with pytest.raises(InterfaceError, match='is not an interface name'):
        class_of(topic, [topic])


def test_another_definition_of_the_same_name_is_told(tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag') as bag:
        bag.add_topic('/x', 'std_msgs/msg/Int32', type_hash='RIHS01_' + '0' * 64)
        bag.write('/x', number(1), START)
    with Reader(tmp_path / 'bag') as read, pytest.raises(InterfaceError, match='another definition'):
        list(read.decoded())


def test_a_sqlite3_file_with_a_journal_is_read(tmp_path: Path) -> None:
    """As a killed recorder leaves it: what was committed is there."""
    bag = Writer(tmp_path / 'bag', storage='sqlite3')
    add_topics(bag)
    for value in range(30):
        put(bag, value)
    bag.flush()
    for value in range(30, 40):
        put(bag, value)
    shutil.copytree(tmp_path / 'bag', tmp_path / 'copy')
    bag.close()
    assert contents(tmp_path / 'copy') == expected(30)


def test_oldest_layouts_of_sqlite3_are_read(tmp_path: Path) -> None:
    file = tmp_path / 'old.db3'
    with sqlite3.connect(file) as database:
        database.executescript(
            'CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);'
            'CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);'
            "INSERT INTO topics VALUES (1, '/numbers', 'std_msgs/msg/Int32', 'cdr');"
        )
        database.execute('INSERT INTO messages VALUES (1, 1, ?, ?)', (START, number(4)))
    database.close()
    with Reader(file) as bag:
        assert [message.data for _, message in bag.decoded()] == [4]
        assert bag.topics[0].qos == ()


def test_qos_of_a_topic_is_named_once(tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag') as bag:
        bag.add_topic('/x', 'std_msgs/msg/Int32', qos=[QoS(), QoS(), LATCHED])
    with Reader(tmp_path / 'bag') as read:
        assert read.topics[0].qos == (QoS().stated(), LATCHED.stated())
