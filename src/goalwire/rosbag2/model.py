"""The content of a bag: topics, messages, and the facts of its metadata."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from goalwire.records import record
from goalwire.rules.qos import QoS

METADATA_FILE = 'metadata.yaml'
SERVICE_EVENT = '/_service_event'
SUFFIXES = {'.mcap': 'mcap', '.db3': 'sqlite3'}
"""rosbag2's storage identifiers by the suffixes of file names."""


@record
class Schema:
    """A type's definition, and the definitions of all types that it contains."""

    encoding: str = ''
    """'ros2msg', 'ros2idl', or '' if the definition is unknown."""
    text: str = ''


@record
class Topic:
    """A topic of a bag."""

    name: str
    type_name: str
    """The name of the type, such as 'std_msgs/msg/String'."""
    type_hash: str = ''
    """The hash of the topic's type, `RIHS01_…`; '' if it is unknown."""
    qos: tuple[QoS, ...] = ()
    """The QoS profiles that the topic's publishers offered, without duplicates."""
    schema: Schema = Schema()
    serialization: str = 'cdr'


class Message(NamedTuple):
    """One serialized message; times in ns since the UNIX epoch."""

    topic: str
    time: int
    """When the message was recorded. The messages of a bag are in the order of this time."""
    data: bytes
    sent: int
    """When the message was published, if the bag contains that time; else the same as `time`."""
    sequence: int = 0
    """The publisher's sequence number of the message; 0 if the bag has none."""


@record
class FileFacts:
    """The facts about one file of a bag; times in ns."""

    path: str
    """The file's name, without a folder."""
    start: int = 0
    duration: int = 0
    count: int = 0


@record
class BagFacts:
    """The content of `metadata.yaml`; times in ns."""

    storage: str
    topics: tuple[Topic, ...] = ()
    counts: tuple[int, ...] = ()
    """The number of messages of each topic, in the order of `topics`."""
    files: tuple[FileFacts, ...] = ()
    start: int = 0
    duration: int = 0
    compression_format: str = ''
    compression_mode: str = ''
    """The unit of compression: '' (nothing is compressed), 'file' or 'message'."""
    custom_data: tuple[tuple[str, str], ...] = ()
    ros_distro: str = ''
    version: int = 9

    @property
    def count(self) -> int:
        """The number of messages in the bag."""
        return sum(self.counts)


def span_of(files: Iterable[FileFacts]) -> tuple[int, int]:
    """Return start and duration of several files together, in ns; files without messages are ignored."""
    filled = [file for file in files if file.count]
    if not filled:
        return 0, 0
    start = min(file.start for file in filled)
    return start, max(file.start + file.duration for file in filled) - start
