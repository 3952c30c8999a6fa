"""Our bags read by `rosbags` and `mcap-ros2-support` of PyPI, and theirs read by ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.bags import NUMBERS, START, WORDS, contents, expected, files_of, number, word, write_bag

from goalwire.cdr.codec import encoder
from goalwire.idl import get_interface
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer

EVENT = 'example_interfaces/srv/AddTwoInts_Event'
FEEDBACK = 'example_interfaces/action/Fibonacci_FeedbackMessage'


@pytest.fixture(scope='module')
def store() -> Any:
    typesys = pytest.importorskip('rosbags.typesys')
    return typesys.get_typestore(typesys.Stores.ROS2_JAZZY)


@pytest.mark.parametrize(
    'options',
    [
        {},
        {'preset': 'zstd_fast'},
        {'max_bytes': 800},
        {'compress_files': True},
        {'storage': 'sqlite3'},
        {'storage': 'sqlite3', 'compress_messages': True},
    ],
    ids=str,
)
def test_rosbags_reads_ours(tmp_path: Path, store: Any, options: dict[str, Any]) -> None:
    from rosbags.rosbag2 import Reader as TheirReader

    path = write_bag(tmp_path / 'bag', **options)
    with TheirReader(path) as bag:
        assert bag.message_count == 110
        found = []
        for connection, time, data in bag.messages():
            found.append((connection.topic, time, bytes(data)))
            assert store.deserialize_cdr(data, connection.msgtype) is not None
        assert found == expected()
        types = {each.topic: each.digest for each in bag.connections}
        assert types[NUMBERS] == store.hash_rihs01('std_msgs/msg/Int32')
        offered = {each.topic: getattr(each.ext, 'offered_qos_profiles') for each in bag.connections}  # noqa: B009
        assert offered[NUMBERS][0].depth == 7
        assert offered[WORDS][0].durability.name == 'TRANSIENT_LOCAL'


def test_rosbags_reads_ours_while_it_is_written(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Reader as TheirReader

    with Writer(tmp_path / 'bag') as bag:
        bag.add_topic(NUMBERS, 'std_msgs/msg/Int32')
        for value in range(30):
            bag.write(NUMBERS, number(value), START + value)
            if value:  # the first message is in the file at once
                bag.flush()
            with TheirReader(tmp_path / 'bag') as read:
                assert sum(1 for _ in read.messages()) == value + 1


def _write_parts(path: Path) -> None:
    """Write a word, an event of a service and feedback of an action."""
    event, feedback = get_interface(EVENT), get_interface(FEEDBACK)
    request = get_interface('example_interfaces/srv/AddTwoInts_Request')(a=2, b=3)
    message = feedback()
    message.feedback.sequence = [1, 1, 2]
    with Writer(path, preset='zstd_small') as bag:
        bag.add_topic(WORDS, 'std_msgs/msg/String')
        bag.add_topic('/add/_service_event', EVENT)
        bag.add_topic('/fibonacci/_action/feedback', FEEDBACK)
        bag.write(WORDS, word('hello'), START)
        bag.write('/add/_service_event', encoder(event)(event(request=[request])), START + 1)
        bag.write('/fibonacci/_action/feedback', encoder(feedback)(message), START + 2)


def test_mcap_ros2_reads_ours(tmp_path: Path) -> None:
    """It knows types by the schemas in the file alone. Names of derived types it takes for mistakes."""
    reader = pytest.importorskip('mcap_ros2.reader')
    _write_parts(tmp_path / 'bag')
    read = list(reader.read_ros2_messages(str(files_of(tmp_path / 'bag')[0]), topics=[WORDS]))
    assert [each.ros_msg.data for each in read] == ['hello']
    assert [each.log_time_ns for each in read] == [START]
    path = write_bag(tmp_path / 'numbers')
    read = list(reader.read_ros2_messages(str(files_of(path)[0]), topics=[NUMBERS]))
    assert [each.ros_msg.data for each in read] == list(range(100))


def test_rosbags_decodes_derived_types_by_our_schemas(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Reader as TheirReader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    _write_parts(tmp_path / 'bag')
    found: dict[str, Any] = {}
    with TheirReader(tmp_path / 'bag') as bag:
        for connection, _, data in bag.messages():
            store = get_typestore(Stores.EMPTY)
            types = get_types_from_msg(connection.msgdef.data, connection.msgtype)
            store.register(types)
            found[connection.topic] = store.deserialize_cdr(data, next(iter(types)))
    assert found['/add/_service_event'].request[0].b == 3
    assert list(found['/fibonacci/_action/feedback'].feedback.sequence) == [1, 1, 2]


def _write_theirs(path: Path, store: Any, version: Any, plugin: str, mode: str) -> None:
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    no_time = QosTime(0, 0)
    qos = Qos(
        QosHistory.KEEP_LAST,
        7,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL,
        no_time,
        no_time,
        QosLiveliness.AUTOMATIC,
        no_time,
        avoid_ros_namespace_conventions=False,
    )
    bag = Writer(path, version=version, storage_plugin=StoragePlugin[plugin])
    bag.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with bag:
        topics = {
            NUMBERS: bag.add_connection(
                NUMBERS, 'std_msgs/msg/Int32', typestore=store, offered_qos_profiles=[qos]
            ),
            WORDS: bag.add_connection(WORDS, 'std_msgs/msg/String', typestore=store),
        }
        for topic, time, data in expected():
            bag.write(topics[topic], time, data)


@pytest.mark.parametrize('version', [8, 9])
@pytest.mark.parametrize(
    ('plugin', 'mode'),
    [
        ('MCAP', 'NONE'),
        ('MCAP', 'FILE'),
        ('MCAP', 'STORAGE'),
        ('SQLITE3', 'NONE'),
        ('SQLITE3', 'FILE'),
        ('SQLITE3', 'MESSAGE'),
    ],
)
def test_ours_reads_those_of_rosbags(
    tmp_path: Path, store: Any, version: int, plugin: str, mode: str
) -> None:
    _write_theirs(tmp_path / 'bag', store, version, plugin, mode)
    assert contents(tmp_path / 'bag') == expected()
    with Reader(tmp_path / 'bag') as bag:
        assert list(bag.check()) == []
        numbers = next(topic for topic in bag.topics if topic.name == NUMBERS)
        assert numbers.qos[0].depth == 7
        assert numbers.qos[0].is_transient_local
        assert numbers.type_hash == store.hash_rihs01('std_msgs/msg/Int32')


@pytest.mark.parametrize('use_chunking', [True, False])
@pytest.mark.parametrize('compression', ['NONE', 'LZ4', 'ZSTD'])
def test_ours_reads_those_of_mcap_ros2(tmp_path: Path, use_chunking: bool, compression: str) -> None:
    writer = pytest.importorskip('mcap_ros2.writer')
    from mcap.writer import CompressionType, Writer

    class Unchunked(Writer):
        """mcap-ros2-support's writer does not hand the flag on."""

        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options | {'use_chunking': use_chunking})

    file = tmp_path / 'theirs.mcap'
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writer, 'McapWriter', Unchunked)
        with writer.Writer(str(file), compression=CompressionType[compression]) as bag:
            schema = bag.register_msgdef('std_msgs/msg/Int32', 'int32 data')
            for value in range(200):
                bag.write_message(NUMBERS, schema, {'data': value}, log_time=START + value)
    with Reader(file) as read:
        assert [message.data for _, message in read.decoded()] == list(range(200))
        assert list(read.check()) == []
