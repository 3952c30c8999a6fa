"""Bags made of bags: merged, cut, filtered, renamed, checked, repaired, reindexed, exported."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from helpers.bags import (
    MS,
    NUMBERS,
    START,
    WORDS,
    add_topics,
    contents,
    expected,
    files_of,
    number,
    put,
    write_bag,
)

from goalwire.apps.bag.rewriting import Cut, reindex, repair, rewrite
from goalwire.apps.bag.selection import Names, Selection
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.main import run_command
from goalwire.errors import BagError
from goalwire.rosbag2.metadata import read_metadata
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer


def broken_bag(path: Path) -> Path:
    """A bag of five chunks, the third of which is broken."""
    with Writer(path) as bag:
        add_topics(bag)
        for value in range(100):
            put(bag, value)
            if value % 20 == 19:
                bag.flush()
    file = files_of(path)[0]
    data = bytearray(file.read_bytes())
    data[data.index(number(45)) + 5] ^= 0xFF
    file.write_bytes(data)
    return path


RESCUED = [each for each in expected() if not START + 40 * MS <= each[1] < START + 60 * MS]


def test_bags_are_merged_in_the_order_of_time(tmp_path: Path) -> None:
    with Writer(tmp_path / 'other') as bag:
        bag.add_topic('/other', 'std_msgs/msg/Int32')
        for value in range(50):
            bag.write('/other', number(value), START + value * MS + 7)
    with (
        Reader(write_bag(tmp_path / 'bag')) as one,
        Reader(tmp_path / 'other') as two,
        Writer(tmp_path / 'merged') as target,
    ):
        assert rewrite([one, two], target, Cut()) == 160
    found = contents(tmp_path / 'merged')
    assert found == sorted(found, key=lambda each: each[1])
    assert [each for each in found if each[0] != '/other'] == expected()


def test_a_bag_is_cut_filtered_and_renamed(tmp_path: Path) -> None:
    selection = Selection(Names(some=frozenset({NUMBERS})))
    cut = Cut(selection, START + 10 * MS, START + 20 * MS, ((NUMBERS, '/n'),))
    with Reader(write_bag(tmp_path / 'bag')) as source, Writer(tmp_path / 'cut') as target:
        assert rewrite([source], target, cut) == 10
    assert contents(tmp_path / 'cut') == [('/n', START + v * MS, number(v)) for v in range(10, 20)]
    with Reader(tmp_path / 'cut') as bag:
        assert [topic.name for topic in bag.topics] == ['/n']
        assert bag.topics[0].qos[0].depth == 7


def test_one_name_of_two_types_is_refused(tmp_path: Path) -> None:
    with Writer(tmp_path / 'other') as bag:
        bag.add_topic(NUMBERS, 'std_msgs/msg/Int64')
    with (
        Reader(write_bag(tmp_path / 'bag')) as one,
        Reader(tmp_path / 'other') as two,
        Writer(tmp_path / 'merged') as target,
        pytest.raises(BagError, match='another name'),
    ):
        rewrite([one, two], target, Cut())


def test_what_can_be_read_is_rescued(tmp_path: Path) -> None:
    with Reader(broken_bag(tmp_path / 'bag')) as source, Writer(tmp_path / 'whole') as target:
        assert repair(source, target) == len(RESCUED)
    assert contents(tmp_path / 'whole') == RESCUED


def test_metadata_is_written_anew(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', max_bytes=1000, custom_data={'robot': 'r2'})
    before = read_metadata(str(path / 'metadata.yaml'))
    (path / 'metadata.yaml').write_text('nothing of use')
    reindex(str(path)).close()
    after = read_metadata(str(path / 'metadata.yaml'))
    assert (after.files, after.counts) == (before.files, before.counts)
    assert [topic.qos for topic in after.topics] == [topic.qos for topic in before.topics]
    assert (after.custom_data, after.ros_distro) == ((('robot', 'r2'),), 'rolling')
    with pytest.raises(BagError, match='no files'):
        reindex(str(tmp_path))
    with pytest.raises(FileNotFoundError):
        reindex(str(tmp_path / 'nowhere'))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ros2(line: str) -> int:
    return run_command('ros2', line.split())


def test_commands_check_and_repair(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken_bag(here / 'bag')
    assert ros2('bag check bag') == Outcome.FAILED
    told = capsys.readouterr()
    assert 'crc' in told.out
    assert told.err == "ros2: 'bag' is not whole; run: ros2 bag repair bag -o FOLDER\n"
    (here / 'bag' / 'metadata.yaml').unlink()
    assert ros2('bag repair bag -o whole') == 0
    assert capsys.readouterr().out == f"'whole' has the {len(RESCUED)} messages that can be read\n"
    assert ros2('bag check whole') == 0
    assert capsys.readouterr().out == f'{len(RESCUED)} messages in 1 files: every byte is there\n'
    assert ros2('bag reindex bag') == 0
    assert capsys.readouterr().out == '110 messages in 1 files\n'


def test_the_command_converts_by_flags(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_bag(here / 'bag')
    part = '--start-offset 0.05 --playback-duration 0.009 -x words'
    assert ros2(f'bag convert -i bag -o new --output-storage sqlite3 {part}') == 0
    assert capsys.readouterr().out == "'new' has 10 messages\n"
    assert contents(here / 'new') == [(NUMBERS, START + v * MS, number(v)) for v in range(50, 60)]


def test_the_command_converts_by_a_file(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_bag(here / 'bag')
    (here / 'out.yaml').write_text(
        'output_bags:\n'
        '- {uri: all, all: true, storage_preset_profile: zstd_fast}\n'
        f'- {{uri: words, storage_id: sqlite3, topics: [{WORDS}]}}\n'
        '- {uri: none}\n'
    )
    assert ros2('bag convert -i bag mcap -o out.yaml') == 0
    assert capsys.readouterr().out.split('\n')[:3] == [
        "'all' has 110 messages",
        "'words' has 10 messages",
        "'none' has 0 messages",
    ]
    assert contents(here / 'all') == expected()
    assert contents(here / 'words') == [each for each in expected() if each[0] == WORDS]
    (here / 'bad.yaml').write_text('output_bags: 3')
    assert ros2('bag convert -i bag -o bad.yaml') == Outcome.BAD_VALUE


def test_messages_are_exported(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from geometry_msgs.msg import PoseStamped

    from goalwire.cdr.codec import encoder

    pose = PoseStamped()
    pose.pose.position.x = 1.5
    with Writer(here / 'bag') as bag:
        add_topics(bag)
        bag.add_topic('/robot/pose', 'geometry_msgs/msg/PoseStamped')
        put(bag, 0)
        bag.write('/robot/pose', encoder(PoseStamped)(pose), START + 5)
    assert ros2('bag export bag') == 0
    with (here / 'bag_csv' / 'robot__pose.csv').open(newline='') as file:
        (row,) = csv.DictReader(file)
    assert (row['time'], row['pose.position.x'], row['header.frame_id']) == (str(START + 5), '1.5', '')
    assert ros2('bag export bag') == Outcome.FAILED
    capsys.readouterr()
    assert ros2('bag export bag --format jsonl --topics /words') == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert json.loads(line) == {
        'topic': WORDS, 'time': START + 1, 'sent': START + 1, 'message': {'data': 'at 0'},
    }  # fmt: skip
    assert ros2('bag export bag --format jsonl -o all.jsonl') == 0
    assert len((here / 'all.jsonl').read_text().splitlines()) == 3
