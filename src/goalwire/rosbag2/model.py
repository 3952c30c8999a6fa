"""The content of a bag: topics, messages, and the facts of its metadata."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from goalwire.records import record
from goalwire.rules.qos import QoS

METADATA_FILE = 'metadata.yaml'
SERVICE_EVENT = '/_service_event'
SUFFIXES = {'.mcap': 'mcap', '.db3': 'sqlite3'}
"""Storage identifiers by the names of files."""


@record
class Schema:
    """A type's definition, with those of all types it contains."""

    encoding: str = ''
    """'ros2msg', 'ros2idl', or '' if the definition is unknown."""
    text: str = ''


@record
class Topic:
    """A topic of a bag."""

    name: str
    type_name: str
    """The type, as 'std_msgs/msg/String'."""
    type_hash: str = ''
    """Its type's hash, `RIHS01_…`; '' if it is unknown."""
    qos: tuple[QoS, ...] = ()
    """The QoS profiles that its publishers offered, without duplicates."""
    schema: Schema = Schema()
    serialization: str = 'cdr'


class Message(NamedTuple):
    """One serialized message; times in ns since the UNIX epoch."""

    topic: str
    time: int
    """When it was recorded; bags are in this order."""
    data: bytes
    sent: int
    """When it was published, if the bag tells that; else the same as `time`."""
    sequence: int = 0
    """The publisher's sequence number; 0 if there is none."""


@record
class FileFacts:
    """One file of a bag."""

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
    """How many messages each of the topics has."""
    files: tuple[FileFacts, ...] = ()
    start: int = 0
    duration: int = 0
    compression_format: str = ''
    compression_mode: str = ''
    """The kind of compression: '', 'file' or 'message'."""
    custom_data: tuple[tuple[str, str], ...] = ()
    ros_distro: str = ''
    version: int = 9

    @property
    def count(self) -> int:
        """How many messages there are."""
        return sum(self.counts)


def span_of(files: Iterable[FileFacts]) -> tuple[int, int]:
    """Return start and duration of several files together, in ns; files without messages do not count."""
    filled = [file for file in files if file.count]
    if not filled:
        return 0, 0
    start = min(file.start for file in filled)
    return start, max(file.start + file.duration for file in filled) - start
