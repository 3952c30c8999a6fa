"""Writes a bag: a folder with files of MCAP or sqlite3, and their metadata."""

from __future__ import annotations

import os
from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Protocol

from goalwire.errors import BagError
from goalwire.files import show
from goalwire.rosbag2.definitions import schema_of
from goalwire.rosbag2.metadata import bag_text, write_metadata
from goalwire.rosbag2.model import METADATA_FILE, BagFacts, FileFacts, Message, Schema, Topic, span_of
from goalwire.rosbag2.reader import missing_extra
from goalwire.rules.qos import QoS

if TYPE_CHECKING:
    from typing import Self

ROS_DISTRO = 'rolling'
"""The name of the ROS distribution in a bag's metadata if the variable ROS_DISTRO is not set."""
STORAGES = ('mcap', 'sqlite3')
PRESETS = ('none', 'fastwrite', 'zstd_fast', 'zstd_small')


class FileWriter(Protocol):
    """One file of a bag that is being written."""

    path: str
    start: int
    end: int
    count: int

    @property
    def size(self) -> int: ...
    def add_topic(self, topic: Topic) -> None: ...
    def write(self, message: Message) -> None: ...
    def wants_end(self) -> bool: ...
    def flush(self, metadata: str) -> None: ...
    def sync(self) -> None: ...
    def close(self, metadata: str) -> None: ...


class Writer:
    """Writes a bag: `with Writer('folder') as bag:`; only one thread at a time may use it.

    All that was written before the latest `flush` can be read at any moment, also after the process was
    killed.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        storage: str = 'mcap',
        preset: str = 'none',
        max_bytes: int = 0,
        max_duration: float = 0.0,
        max_files: int = 0,
        compress_files: bool = False,
        compress_messages: bool = False,
        custom_data: Mapping[str, str] | None = None,
        ros_distro: str = '',
        on_split: Callable[[str, str], None] | None = None,
    ) -> None:
        """Make the folder and the first file.

        A new file begins after `max_bytes` or `max_duration` s, where these are not 0; if there are more than
        `max_files` files, the oldest is removed. `preset` is a name of PRESETS, for MCAP. With
        `compress_files` each file is compressed when it is closed. With `compress_messages` each message is
        compressed before it is written; rosbag2 reads such messages only from sqlite3. `on_split(closed,
        opened)` is called at each split, with the paths of the closed and the new file. Raises BagError if
        the folder exists, or if storage, preset or compression are unknown or cannot be combined; OSError if
        a file cannot be made.
        """
        self.path = os.fspath(path).rstrip('/') or '/'
        _check_choices(storage, preset, compress_files=compress_files, compress_messages=compress_messages)
        self._storage = storage
        self._make_file = _opener(storage, preset, ros_distro or _distro())
        self._max_bytes = max_bytes
        self._max_duration = int(max_duration * 1e9)
        self._max_files = max_files
        self._compress_files = compress_files
        self._compress = _message_compressor() if compress_messages else None
        self.custom_data: dict[str, str] = dict(custom_data or {})
        """Custom data that is written into the metadata at the next flush."""
        self._ros_distro = ros_distro or _distro()
        self.on_split = on_split
        self._topics: dict[str, Topic] = {}
        self._closed: list[tuple[FileFacts, dict[str, int]]] = []
        """The files before the present one, each with its number of messages by topic."""
        self._counts: dict[str, int] = defaultdict(int)
        self._number = 0
        self._unsynced: deque[str] = deque()
        """Closed files whose data the disk may not have yet."""
        self._is_open = self._has_file = True
        self._has_new_topics = False
        self.heads: Callable[[int], Iterable[Message]] | None = None
        """A function that gets the start time of a further file and returns the messages with which that file
        begins.
        """
        try:
            os.makedirs(self.path)
        except FileExistsError:
            raise BagError(f"'{show(self.path)}' exists already; choose another folder") from None
        self._file = self._next_file()
        self._write_metadata()

    # -- writing ---------------------------------------------------------------------------------------------

    @property
    def count(self) -> int:
        """The number of messages in the files that still exist."""
        return sum(facts.count for facts in self._files())

    @property
    def file(self) -> str:
        """The path of the file that is being written."""
        return self._file.path

    def topic(self, name: str) -> Topic | None:
        """Return the topic of that name; None if it was not added."""
        return self._topics.get(name)

    def add_topic(
        self,
        name: str,
        type_name: str,
        *,
        type_hash: str = '',
        qos: Iterable[QoS] = (),
        schema: Schema | None = None,
        serialization: str = 'cdr',
    ) -> None:
        """Register a topic, before its first message. Adding a topic again changes nothing.

        If schema or hash is not given, it is looked up by the type's name, if the type is known here.
        """
        if name in self._topics:
            return
        if schema is None or not type_hash:
            found, found_hash = schema_of(type_name)
            schema = schema or (found if type_hash in {'', found_hash} else Schema())
            type_hash = type_hash or found_hash
        topic = Topic(name, type_name, type_hash, tuple(dict.fromkeys(qos)), schema, serialization)
        self._topics[name] = topic
        self._file.add_topic(topic)
        self._has_new_topics = True

    def write(self, topic: str, data: bytes, time: int, sent: int | None = None, sequence: int = 0) -> None:
        """Add a serialized message, recorded and sent at these times in ns since the UNIX epoch.

        Raises BagError for a topic that was not added, and if the disk is full or fails: the messages written
        before stay in the files, and `close` completes them.
        """
        if topic not in self._topics:
            raise BagError(f"'{topic}' was not added to the bag before its first message: call add_topic")
        self.put(Message(topic, time, data, time if sent is None else sent, sequence))

    def put(self, message: Message) -> None:
        """Add a Message as `write` does."""
        if self._is_full(message.time):
            self.split(message.time)
        try:
            self._store(message)
            if self._file.wants_end():
                self._file.flush(bag_text(self._facts()))
                if self._has_new_topics:
                    self._write_metadata()  # other threads read the file of metadata
        except OSError as error:
            raise self._make_error(error) from error

    def _store(self, message: Message) -> None:
        if self._compress is not None:
            message = message._replace(data=self._compress(message.data))
        self._file.write(message)
        self._counts[message.topic] += 1

    def _is_full(self, time: int) -> bool:
        file = self._file
        if not file.count:
            return False
        if self._max_bytes and file.size >= self._max_bytes:
            return True
        return bool(self._max_duration) and time - file.start >= self._max_duration

    def flush(self) -> None:
        """Write everything into the files, which are then complete. Raises BagError as `write` does."""
        try:
            self._file.flush(bag_text(self._facts()))
            self._write_metadata()
        except OSError as error:
            raise self._make_error(error) from error

    def sync(self) -> None:
        """Have the system write flushed data and closed files to the disk. Callable from any thread."""
        while self._unsynced:
            _sync(self._unsynced.popleft())
        self._file.sync()

    def split(self, time: int) -> None:
        """Begin a new file, with the messages of `heads` at `time`. Raises BagError as `write` does."""
        closed = self._file.path
        try:
            self._close_file()
            self._file, self._has_file = self._next_file(), True
            for topic in self._topics.values():
                self._file.add_topic(topic)
            for message in self.heads(time) if self.heads is not None else ():
                self._store(message)
            self._remove_oldest()
            self._write_metadata()
        except OSError as error:
            raise self._make_error(error) from error
        if self.on_split is not None:
            self.on_split(closed, self._file.path)

    def close(self) -> None:
        """Close the bag: its files and its metadata. Idempotent. Raises BagError as `write` does."""
        if not self._is_open:
            return
        self._is_open = False
        try:
            self._close_file()
            self._write_metadata()
            self.sync()
        except OSError as error:
            raise self._make_error(error) from error

    def _make_error(self, error: OSError) -> BagError:
        return BagError(f"the bag '{show(self.path)}' cannot be written: {error.strerror or error}")

    # -- files -----------------------------------------------------------------------------------------------

    def _next_file(self) -> FileWriter:
        name = f'{os.path.basename(self.path)}_{self._number}.{_SUFFIX[self._storage]}'
        self._number += 1
        return self._make_file(os.path.join(self.path, name))

    def _close_file(self) -> None:
        file = self._file
        try:
            file.close(bag_text(self._facts()))
        finally:
            path = file.path
            counts, self._counts, self._has_file = dict(self._counts), defaultdict(int), False
            if self._compress_files:
                path = _compress_closed(path)
            facts = _facts_of(file, path)
            self._closed.append((facts, counts))
            self._unsynced.append(path)

    def _remove_oldest(self) -> None:
        while self._max_files and len(self._closed) + 1 > self._max_files:
            facts, _ = self._closed.pop(0)
            os.remove(os.path.join(self.path, facts.path))

    def _write_metadata(self) -> None:
        self._has_new_topics = False
        write_metadata(self.path, self._facts(), METADATA_FILE)

    def _files(self) -> list[FileFacts]:
        """Return the facts of the files that still exist, the present one included."""
        present = [_facts_of(self._file, self._file.path)] if self._has_file else []
        return [*(facts for facts, _ in self._closed), *present]

    def _facts(self) -> BagFacts:
        totals: dict[str, int] = defaultdict(int)
        for counts in (*(counts for _, counts in self._closed), self._counts):
            for name, count in counts.items():
                totals[name] += count
        files = self._files()
        start, duration = span_of(files)
        mode = 'message' if self._compress is not None else 'file' if self._compress_files else ''
        return BagFacts(
            storage=self._storage,
            topics=tuple(self._topics.values()),
            counts=tuple(totals[name] for name in self._topics),
            files=tuple(files),
            start=start,
            duration=duration,
            compression_format='zstd' if mode else '',
            compression_mode=mode,
            custom_data=tuple(self.custom_data.items()),
            ros_distro=self._ros_distro,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()


_SUFFIX = {'mcap': 'mcap', 'sqlite3': 'db3'}


def _check_choices(storage: str, preset: str, *, compress_files: bool, compress_messages: bool) -> None:
    """Raise BagError if storage or preset are unknown, or if they and the compression do not go together."""
    if storage not in STORAGES:
        raise BagError(f"there is no storage '{storage}': choose {' or '.join(STORAGES)}")
    if preset not in PRESETS:
        raise BagError(f"there is no preset '{preset}': choose {', '.join(PRESETS)}")
    if storage != 'mcap' and preset != 'none':
        raise BagError(f"the storage {storage} has no preset '{preset}'")
    if compress_messages and (storage != 'sqlite3' or compress_files):
        raise BagError(
            f'the storage {storage} cannot compress messages one by one'
            if storage != 'sqlite3'
            else 'either files or messages are compressed, not both'
        )


def _facts_of(file: FileWriter, path: str) -> FileFacts:
    return FileFacts(os.path.basename(path), file.start, file.end - file.start, file.count)


def _distro() -> str:
    return os.environ.get('ROS_DISTRO') or ROS_DISTRO


def _opener(storage: str, preset: str, ros_distro: str) -> Callable[[str], FileWriter]:
    """Return a function that opens the files of a bag; raises BagError if a package is not installed."""
    if storage == 'sqlite3':
        from goalwire.rosbag2.sqlite_writer import SqliteWriter

        return lambda path: SqliteWriter(path, ros_distro)
    try:
        from goalwire.rosbag2.mcap_writer import McapWriter, compression

        chosen, chunk_bytes = compression(preset)
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    return lambda path: McapWriter(path, compression=chosen, chunk_bytes=chunk_bytes)


def _sync(path: str) -> None:
    """Have the system write a file's data to the disk; ignore a deleted file."""
    with suppress(OSError):
        descriptor = os.open(path, os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _message_compressor() -> Callable[[bytes], bytes]:
    """Return a function that compresses a message; raises BagError if zstandard is not installed."""
    try:
        import zstandard
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    return zstandard.ZstdCompressor().compress


def _compress_closed(path: str) -> str:
    """Compress a closed file, and return the path of the compressed file."""
    import zstandard

    packed = f'{path}.zstd'
    with open(path, 'rb') as source, open(f'{packed}.new', 'wb') as target:
        zstandard.ZstdCompressor().copy_stream(source, target)
    os.replace(f'{packed}.new', packed)
    os.remove(path)
    return packed
