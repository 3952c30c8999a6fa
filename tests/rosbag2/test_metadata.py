"""metadata.yaml: each version is read, the newest is written."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from goalwire.errors import BagError
from goalwire.rosbag2.metadata import facts_of_text, metadata_text, qos_of_text, qos_text, read_metadata
from goalwire.rosbag2.model import BagFacts, FileFacts, Topic
from goalwire.rules.qos import (
    SENSOR_DATA,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)

_START = """rosbag2_bagfile_information:
  version: {version}
  storage_identifier: sqlite3
  relative_file_paths:
    - {path}
  duration:
    nanoseconds: 200
  starting_time:
    nanoseconds_since_epoch: 1000
  message_count: 5
  topics_with_message_count:
    - topic_metadata:
        name: /chatter
        type: std_msgs/msg/String
        serialization_format: cdr
{topic}
      message_count: 5
{end}
"""
_OLD_QOS = r"""        offered_qos_profiles: "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 2147483647\n    nsec: 4294967295\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: 1\n    nsec: 5\n  avoid_ros_namespace_conventions: false"
"""  # noqa: E501 - as rosbag2 wrote it
_COMPRESSION = '  compression_format: zstd\n  compression_mode: FILE\n'
_FILES = """  files:
    - path: bag_0.db3
      starting_time:
        nanoseconds_since_epoch: 1000
      duration:
        nanoseconds: 200
      message_count: 5
"""
_HASH = '        type_description_hash: RIHS01_abc\n'
VERSIONS = {
    1: ('bag/bag_0.db3', '', ''),
    2: ('bag/bag_0.db3', '', ''),
    3: ('bag/bag_0.db3', '', _COMPRESSION),
    4: ('bag_0.db3', _OLD_QOS, _COMPRESSION),
    5: ('bag_0.db3', _OLD_QOS, _COMPRESSION + _FILES),
    6: ('bag_0.db3', _OLD_QOS, _COMPRESSION + _FILES + '  custom_data:\n    robot: r2\n'),
    7: ('bag_0.db3', _OLD_QOS + _HASH, _COMPRESSION + _FILES + '  custom_data: ~\n'),
    8: ('bag_0.db3', _OLD_QOS + _HASH, _COMPRESSION + _FILES + '  custom_data: ~\n  ros_distro: jazzy\n'),
}


@pytest.mark.parametrize('version', VERSIONS)
def test_each_version_is_read(tmp_path: Path, version: int) -> None:
    path, topic, end = VERSIONS[version]
    file = tmp_path / 'metadata.yaml'
    file.write_text(_START.format(version=version, path=path, topic=topic, end=end))
    facts = read_metadata(str(file))
    assert (facts.version, facts.start, facts.duration, facts.count) == (version, 1000, 200, 5)
    assert facts.files == (FileFacts('bag_0.db3', 1000, 200, 5) if version >= 5 else FileFacts('bag_0.db3'),)
    assert facts.compression_mode == ('file' if version >= 3 else '')
    (chatter,) = facts.topics
    assert chatter.type_hash == ('RIHS01_abc' if version >= 7 else '')
    assert facts.custom_data == ((('robot', 'r2'),) if version == 6 else ())
    assert facts.ros_distro == ('jazzy' if version >= 8 else '')
    if version >= 4:
        (qos,) = chatter.qos
        assert qos.history is HistoryPolicy.UNKNOWN
        assert qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        assert qos.lease_ns == 1_000_000_005
        assert qos.lifespan_ns == 2**63 - 1


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    topics = (
        Topic('/a', 'p/msg/A', 'RIHS01_x', (SENSOR_DATA.stated(), QoS().stated())),
        Topic('/b "quoted": é', 'p/msg/B'),
    )
    files = (FileFacts('bag_0.mcap', 5, 6, 7), FileFacts('bag_1.mcap', 11, 1, 1))
    custom = (('key: with colon', '- value'), ('empty', ''))
    facts = BagFacts('mcap', topics, (7, 1), files, 5, 7, 'zstd', 'file', custom, 'jazzy')
    file = tmp_path / 'metadata.yaml'
    file.write_text(metadata_text(facts), encoding='utf-8')
    assert read_metadata(str(file)) == facts
    assert yaml.safe_load(file.read_text(encoding='utf-8'))['rosbag2_bagfile_information']['version'] == 9


def test_an_empty_bag_is_written_and_read(tmp_path: Path) -> None:
    file = tmp_path / 'metadata.yaml'
    file.write_text(metadata_text(BagFacts('mcap')))
    assert read_metadata(str(file)) == BagFacts('mcap')


def test_qos_are_spelt_as_version_9_does() -> None:
    qos = QoS(3, HistoryPolicy.KEEP_ALL, ReliabilityPolicy.BEST_EFFORT, liveliness=LivelinessPolicy.AUTOMATIC)
    (found,) = yaml.safe_load(qos_text([qos]))
    assert list(found) == [
        'history',
        'depth',
        'reliability',
        'durability',
        'deadline',
        'lifespan',
        'liveliness',
        'liveliness_lease_duration',
        'avoid_ros_namespace_conventions',
    ]
    assert (found['history'], found['reliability']) == ('keep_all', 'best_effort')
    assert found['deadline'] == {'sec': 9223372036, 'nsec': 854775807}
    assert qos_of_text(qos_text([qos])) == (qos.stated(),)
    assert qos_of_text('') == qos_of_text('{') == ()


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        ('a: [', 'not YAML'),
        ('other: 1', 'belongs to no bag'),
        (_START.format(version=10, path='x', topic='', end=''), 'version 10'),
        ('rosbag2_bagfile_information:\n  version: 9\n', 'incomplete or broken'),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / 'metadata.yaml'
    file.write_text(text)
    with pytest.raises(BagError, match=told):
        read_metadata(str(file))


def test_text_of_a_file_that_is_no_map_is_told() -> None:
    with pytest.raises(BagError, match='not a YAML map'):
        facts_of_text('1', 'bag_0.mcap')
