"""Reads a bag: a folder that rosbag2 has written, or one file of such a folder."""

from __future__ import annotations

import heapq
import os
import shutil
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack, suppress
from functools import cached_property
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.errors import BagError
from goalwire.files import show
from goalwire.records import replace
from goalwire.rosbag2.metadata import facts_of_text, read_metadata
from goalwire.rosbag2.model import (
    METADATA_FILE,
    SUFFIXES,
    BagFacts,
    FileFacts,
    Message,
    Topic,
    span_of,
)

if TYPE_CHECKING:
    from typing import Self


class FileReader(Protocol):
    """One open file of a bag."""

    storage: str
    path: str
    problem: str
    metadata: str
    topics: list[Topic]
    counts: Counter[str]
    start: int
    end: int

    @property
    def count(self) -> int: ...
    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Message]: ...
    def check(self) -> Iterator[str]: ...
    def rescued(self) -> Iterator[Message]: ...
    def close(self) -> None: ...


def open_file(path: str) -> FileReader:
    """Open one file of a bag; its suffix decides how. Raises BagError, OSError."""
    storage = SUFFIXES.get(Path(path).suffix)
    if storage == 'mcap':
        try:
            from goalwire.rosbag2.mcap_reader import McapReader
        except ModuleNotFoundError as error:
            raise missing_extra(error) from None
        return McapReader(path)
    if storage == 'sqlite3':
        from goalwire.rosbag2.sqlite_reader import SqliteReader

        return SqliteReader(path)
    raise BagError(f'{show(path)}: a file of a bag ends with {" or ".join(SUFFIXES)}')


def missing_extra(error: ModuleNotFoundError) -> BagError:
    """Return an error that tells how to install a missing package of the extra `bag`."""
    return BagError(f"bags need the package '{error.name}'; run: pip install 'goalwire[bag]'")


class Reader:
    """Reads a bag: `with Reader('folder') as bag:`, where `bag.messages()` yields the messages in order.

    Only one thread may use it.
    """

    def __init__(self, path: str | os.PathLike[str], *, files: Sequence[str] = ()) -> None:
        """Open the bag; raises BagError, FileNotFoundError.

        With `files`, `path` is the bag's folder, and these files in it are read instead of those in its
        metadata.
        """
        self.path = os.fspath(path)
        self._resources = ExitStack()
        self._files: dict[str, FileReader] = {}
        try:
            folder, names, told = (self.path, list(files), None) if files else _find(self.path)
            for name in names:
                self._open(folder, name)
            told = told or self._read_embedded()
            self._compression = told.compression_mode if told else ''
            self._unpack = _message_unpacker() if self._compression == 'message' else None
            self.facts = self._gather(told, names)
        except BaseException:
            self.close()
            raise

    def _open(self, folder: str, name: str) -> None:
        path = os.path.join(folder, name)
        if Path(name).suffix in {'.zstd', '.zst'}:
            path = self._unpack_file(path)
        file = self._files[name] = open_file(path)
        self._resources.callback(file.close)

    def _unpack_file(self, path: str) -> str:
        """Return the path of an unpacked copy of a compressed file; `close` removes the copy."""
        try:
            import zstandard
        except ModuleNotFoundError as error:
            raise missing_extra(error) from None
        place = self._resources.enter_context(TemporaryDirectory(prefix='goalwire-bag-'))
        unpacked = os.path.join(place, Path(path).stem)
        with open(path, 'rb') as packed, open(unpacked, 'wb') as file:
            try:
                shutil.copyfileobj(zstandard.ZstdDecompressor().stream_reader(packed), file)
            except zstandard.ZstdError as error:
                raise BagError(f'{show(path)}: it cannot be unpacked ({error})') from error
        return unpacked

    def _read_embedded(self) -> BagFacts | None:
        """Return the metadata that the last file with readable metadata contains; None if no file has any."""
        for name, file in reversed(self._files.items()):
            if file.metadata:
                with suppress(BagError):
                    return facts_of_text(file.metadata, name)
        return None

    def _gather(self, told: BagFacts | None, names: list[str]) -> BagFacts:
        """Return the facts that the files contain; the metadata completes them."""
        counts: Counter[str] = Counter()
        topics: dict[str, Topic] = {}
        facts = []
        for name in names:
            file = self._files[name]
            counts.update(file.counts)
            for topic in file.topics:
                topics.setdefault(topic.name, topic)
            facts.append(FileFacts(name, file.start, file.end - file.start, file.count))
        for topic in told.topics if told else ():
            known = topics.get(topic.name, topic)
            topics[topic.name] = replace(
                known, type_hash=known.type_hash or topic.type_hash, qos=known.qos or topic.qos
            )
        start, duration = span_of(facts)
        return BagFacts(
            storage=self._files[names[0]].storage,
            topics=tuple(topics.values()),
            counts=tuple(counts[name] for name in topics),
            files=tuple(facts),
            start=start,
            duration=duration,
            compression_format=told.compression_format if told else '',
            compression_mode=self._compression,
            custom_data=told.custom_data if told else (),
            ros_distro=told.ros_distro if told else '',
            version=told.version if told else 0,
        )

    # -- the bag's facts -------------------------------------------------------------------------------------

    @property
    def topics(self) -> tuple[Topic, ...]:
        """The topics, including those without messages."""
        return self.facts.topics

    @cached_property
    def counts(self) -> dict[str, int]:
        """The number of messages of each topic."""
        return {topic.name: n for topic, n in zip(self.facts.topics, self.facts.counts, strict=True)}

    @property
    def start(self) -> int:
        """When the first message was recorded, in ns since the UNIX epoch; 0 for an empty bag."""
        return self.facts.start

    @property
    def end(self) -> int:
        """When the last message was recorded, in ns since the UNIX epoch."""
        return self.facts.start + self.facts.duration

    @property
    def size(self) -> int:
        """The size of the bag's files on the disk, in bytes."""
        folder = self.path if os.path.isdir(self.path) else os.path.dirname(self.path)
        return sum(os.path.getsize(os.path.join(folder, file.path)) for file in self.facts.files)

    @property
    def problems(self) -> list[str]:
        """The faults that were found when the files were opened, such as files that their writer did not
        close. `check` finds more faults.
        """
        return [f'{name}: {file.problem}' for name, file in self._files.items() if file.problem]

    # -- messages --------------------------------------------------------------------------------------------

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Message]:
        """Yield messages in the order of recording; only messages of `topics`, if given.

        Yields only messages from the time `start` to before `stop`, in ns since the UNIX epoch. Raises
        BagError if bytes are broken.
        """
        opened = sorted(self._files.values(), key=lambda file: file.start)
        order = count()
        active: list[tuple[int, int, Message, Iterator[Message]]] = []

        def advance(messages: Iterator[Message], position: int) -> None:
            message = next(messages, None)
            if message is not None:
                heapq.heappush(active, (message.time, position, message, messages))

        while opened or active:
            while opened and (not active or opened[0].start <= active[0][0]):
                advance(opened.pop(0).messages(topics, start, stop), next(order))
            if active:
                _, position, message, messages = heapq.heappop(active)
                yield self._plain(message)
                advance(messages, position)

    def rescued(self) -> Iterator[Message]:
        """Yield every readable message, file after file; broken parts are left out."""
        for file in self._files.values():
            for message in file.rescued():
                with suppress(BagError):
                    yield self._plain(message)

    def _plain(self, message: Message) -> Message:
        """Return a message with its bytes decompressed; raises BagError if the bytes are broken."""
        if self._unpack is None:
            return message
        try:
            return message._replace(data=self._unpack(message.data))
        except ValueError as error:
            raise BagError(
                f"{show(self.path)}: a message of '{message.topic}' cannot be unpacked ({error})"
            ) from error

    def decoded(
        self, topics: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[tuple[Message, Any]]:
        """Yield the same messages as `messages`, each with its decoded object.

        A type that is unknown here is read from the bag. Raises InterfaceError if the bag lacks it, too, and
        DecodeError for bytes that are not a message.
        """
        from goalwire.rosbag2.types import decoder_of

        decoders = {topic.name: topic for topic in self.topics}
        made: dict[str, Any] = {}
        for message in self.messages(topics, start, stop):
            decode = made.get(message.topic)
            if decode is None:
                decode = made[message.topic] = decoder_of(decoders[message.topic], self.topics)
            yield message, decode(message.data)

    def check(self) -> Iterator[str]:
        """Read every byte of every file, and yield a text for each fault."""
        for name, file in self._files.items():
            for problem in file.check():
                yield f'{name}: {problem}'
            broken = 0 if self._unpack is None else sum(map(self._is_broken, file.rescued()))
            if broken:
                yield f'{name}: {broken:,} messages cannot be unpacked'

    def _is_broken(self, message: Message) -> bool:
        try:
            self._plain(message)
        except BagError:
            return True
        return False

    def close(self) -> None:
        """Close all files. Idempotent."""
        self._resources.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()


def _message_unpacker() -> Callable[[bytes], bytes]:
    """Return a function that decompresses a message, and raises ValueError for broken bytes.

    Raises BagError if zstandard is not installed.
    """
    try:
        from zstandard import ZstdDecompressor, ZstdError
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    decompressor = ZstdDecompressor()

    def unpack(data: bytes) -> bytes:
        try:
            return decompressor.decompress(data)
        except (ZstdError, MemoryError) as error:
            raise ValueError(str(error) or 'it is too large for the memory') from None

    return unpack


def _find(path: str) -> tuple[str, list[str], BagFacts | None]:
    """Return the folder of a bag, its files and its metadata.

    Raises BagError, FileNotFoundError.
    """
    if not os.path.isdir(path):
        if not os.path.exists(path):
            raise FileNotFoundError(f"there is no bag '{show(path)}'")
        return os.path.dirname(path), [os.path.basename(path)], None
    there = os.listdir(path)
    stored = stored_files(path)
    told = None
    if METADATA_FILE in there:
        told = read_metadata(os.path.join(path, METADATA_FILE))
        missing = [file.path for file in told.files if file.path not in there]
        if missing:
            raise BagError(f"{show(path)}: its file '{show(missing[0])}' is missing; see: ros2 bag reindex")
        # A recorder that was killed may have begun a file that the metadata does not name yet.
        named = [file.path for file in told.files]
        stored = named + [name for name in stored if name not in named and _follows(name, named)]
    if not stored:
        raise BagError(
            f'{show(path)}: no bag is there: a bag has files that end with {" or ".join(SUFFIXES)}'
        )
    return path, stored, told


def stored_files(folder: str) -> list[str]:
    """Return the names of the bag's files in a folder, in the order of their numbers."""
    return sorted(filter(_is_stored, os.listdir(folder)), key=_natural)


def _is_stored(name: str) -> bool:
    path = Path(name)
    return (path.with_suffix('') if path.suffix in {'.zstd', '.zst'} else path).suffix in SUFFIXES


def _follows(name: str, named: list[str]) -> bool:
    """Return whether a file's number comes after the numbers of the files in the metadata."""
    return (
        bool(named)
        and _natural(name)[:-1] == _natural(named[-1])[:-1]
        and _natural(name) > _natural(named[-1])
    )


def _natural(name: str) -> tuple[str, int]:
    """Return a sort key that puts bag_2 before bag_10."""
    stem = name.partition('.')[0]
    head, _, number = stem.rpartition('_')
    return (head, int(number)) if number.isdecimal() else (stem, -1)
