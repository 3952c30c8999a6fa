"""Makes bags from bags: merges, cuts, filters, renames, repairs, and rebuilds metadata."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

from goalwire.apps.bag.selection import Selection
from goalwire.errors import BagError
from goalwire.files import show
from goalwire.records import record
from goalwire.rosbag2.metadata import write_metadata
from goalwire.rosbag2.model import METADATA_FILE, Message
from goalwire.rosbag2.reader import Reader, stored_files
from goalwire.rosbag2.writer import Writer


@record
class Cut:
    """The messages to take from a bag, and the names under which they are written."""

    selection: Selection | None = None
    start: int | None = None
    """Only messages from this time on are written, in ns."""
    stop: int | None = None
    """Only messages before this time are written, in ns."""
    renames: tuple[tuple[str, str], ...] = ()


def rewrite(sources: Sequence[Reader], target: Writer, cut: Cut) -> int:
    """Write the messages of several bags into one, in the order of their times; return how many.

    Raises BagError if a name has two types among the bags.
    """
    names = dict(cut.renames)
    for source in sources:
        _add_topics(source, target, cut.selection, names)
    merged = heapq.merge(
        *(_take_messages(source, cut) for source in sources), key=lambda message: message.time
    )
    count = 0
    for message in merged:
        target.put(message._replace(topic=names.get(message.topic, message.topic)))
        count += 1
    return count


def _add_topics(
    source: Reader, target: Writer, selection: Selection | None, names: Mapping[str, str]
) -> None:
    for topic in source.topics:
        if selection is not None and not selection.wants(topic.name, topic.type_name):
            continue
        name = names.get(topic.name, topic.name)
        known = target.topic(name)
        if known is not None and (known.type_name, known.type_hash) != (topic.type_name, topic.type_hash):
            raise BagError(
                f"'{name}' has the types {known.type_name} and {topic.type_name}, or two definitions; "
                f'give one of them another name'
            )
        target.add_topic(
            name,
            topic.type_name,
            type_hash=topic.type_hash,
            qos=topic.qos,
            schema=topic.schema,
            serialization=topic.serialization,
        )


def _take_messages(source: Reader, cut: Cut) -> Iterator[Message]:
    names = [
        topic.name
        for topic in source.topics
        if cut.selection is None or cut.selection.wants(topic.name, topic.type_name)
    ]
    yield from source.messages(names, cut.start, cut.stop)


def repair(source: Reader, target: Writer) -> int:
    """Write the readable messages of a bag into another bag, and return their number."""
    _add_topics(source, target, None, {})
    count = 0
    for message in source.rescued():
        target.put(message)
        count += 1
    return count


def reindex(folder: str) -> Reader:
    """Write the metadata of a folder anew, from its files, and return the bag, opened.

    Raises BagError if there are no files, or if one of them cannot be read.
    """
    if not Path(folder).is_dir():
        raise FileNotFoundError(f"nothing is at '{show(folder)}'")
    files = stored_files(folder)
    if not files:
        raise BagError(f'{show(folder)}: it has no files of a bag')
    bag = Reader(folder, files=files)
    write_metadata(folder, bag.facts, METADATA_FILE)
    return bag


def open_all(paths: Iterable[str], stack: ExitStack) -> list[Reader]:
    """Open several bags; closing the stack closes them."""
    return [stack.enter_context(Reader(path)) for path in paths]
