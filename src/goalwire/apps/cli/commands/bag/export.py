"""ros2 bag export: bags as CSV, JSON lines, Parquet, files of pictures, or a dataset of LeRobot."""

from __future__ import annotations

import csv
from argparse import ArgumentParser, Namespace
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from goalwire.apps.bag.exporting.folders import Written, file_stems, new_folder
from goalwire.apps.cli.commands.bag.choosing import bags_argument, open_bag
from goalwire.apps.cli.commands.bag.lerobot import add_lerobot_arguments, export_dataset
from goalwire.apps.cli.commands.bag.play import add_choice, selection
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import json_text, tell
from goalwire.errors import InterfaceError
from goalwire.observe.messages import as_dict
from goalwire.rosbag2.types import class_of

if TYPE_CHECKING:
    from goalwire.apps.bag.selection import Selection
    from goalwire.apps.cli.framework.output import Output
    from goalwire.rosbag2.reader import Reader

FORMATS = ('csv', 'jsonl', 'parquet', 'images', 'lerobot')


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag export`."""
    bags_argument(parser)
    parser.add_argument('--format', choices=FORMATS, default='csv', help='What to write (default: csv)')
    parser.add_argument(
        '-o',
        '--output',
        metavar='PATH',
        help='Folder to make, or file of the JSON lines (default: the name of the bag, _ and the format)',
    )
    add_choice(parser)
    add_lerobot_arguments(parser)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Export the messages of the bag; JSON lines go to standard output if no file is named."""
    if arguments.format == 'lerobot':
        return export_dataset(arguments)
    path, *others = arguments.bag_path
    if others:
        raise CommandError(
            Outcome.USAGE,
            f'{arguments.prog}: {arguments.format} takes one bag',
            'export one bag after the other; only --format lerobot takes several',
        )
    with open_bag(arguments, path) as bag:
        chosen = selection(arguments)
        topics, unknown = _readable(bag, chosen)
        start = bag.start + int(arguments.start_offset * 1e9)
        if arguments.format == 'jsonl':
            _write_json_lines(bag, topics, start, arguments.output, output)
            return Outcome.FAILED if unknown else Outcome.OK
        folder = Path(arguments.output or f'{Path(bag.path).stem}_{arguments.format}')
        written = _write_folder(arguments.format, bag, topics, start, folder)
    for each in written:
        what = 'pictures' if arguments.format == 'images' else 'rows'
        tell(f"'{each.path}' has {each.count:,} {what}")
        for reason in each.left_out:
            tell(f"'{each.path}': {reason}")
    return Outcome.FAILED if unknown or any(each.left_out for each in written) else Outcome.OK


def _readable(bag: Reader, chosen: Selection) -> tuple[list[str], bool]:
    """Return the chosen topics of known types, and True if a chosen topic was left out, with a warning."""
    found: list[str] = []
    has_unknown = False
    for topic in bag.topics:
        if not chosen.wants(topic.name, topic.type_name):
            continue
        try:
            class_of(topic, bag.topics)
        except InterfaceError as error:
            has_unknown = True
            tell(f"'{topic.name}' is left out: {error}")
        else:
            found.append(topic.name)
    return found, has_unknown


def _write_folder(kind: str, bag: Reader, topics: list[str], start: int, folder: Path) -> list[Written]:
    if kind == 'parquet':
        from goalwire.apps.bag.exporting.parquet_files import write_parquet

        return write_parquet(bag, topics, start, folder)
    if kind == 'images':
        from goalwire.apps.bag.exporting.pictures import COMPRESSED, IMAGE, write_pictures

        types = {topic.name: topic.type_name for topic in bag.topics}
        pictures = [topic for topic in topics if types[topic] in {IMAGE, COMPRESSED}]
        if not pictures:
            raise CommandError(
                Outcome.NOT_FOUND,
                f"'{bag.path}' has no pictures",
                f'they are topics of {IMAGE} or {COMPRESSED}',
            )
        return write_pictures(bag, pictures, start, folder)
    return _write_csv(bag, topics, start, folder)


def _write_json_lines(
    bag: Reader, topics: Collection[str], start: int, path: str | None, output: Output
) -> None:
    lines = (
        {'topic': message.topic, 'time': message.time, 'sent': message.sent, 'message': as_dict(decoded)}
        for message, decoded in bag.decoded(topics, start)
    )
    if path is None:
        for line in lines:
            output.data(line)
        return
    with Path(path).open('x', encoding='utf-8') as file:
        file.writelines(json_text(line) + '\n' for line in lines)


def _write_csv(bag: Reader, topics: Collection[str], start: int, folder: Path) -> list[Written]:
    """Write a file for each topic, with a column for each field; nested fields are named `pose.x`."""
    stems = file_stems(topics)
    new_folder(folder)
    counts: dict[Path, int] = {}
    with ExitStack() as stack:
        writers: dict[str, tuple[Path, Any]] = {}
        for message, decoded in bag.decoded(topics, start):
            fields = dict(_flat(as_dict(decoded)))
            if message.topic not in writers:
                path = folder / f'{stems[message.topic]}.csv'
                file = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
                writers[message.topic] = path, csv.writer(file)
                writers[message.topic][1].writerow(['time', 'sent', *fields])
            path, writer = writers[message.topic]
            writer.writerow([message.time, message.sent, *fields.values()])
            counts[path] = counts.get(path, 0) + 1
    return [Written(path, count) for path, count in counts.items()]


def _flat(value: Mapping[str, Any], before: str = '') -> Iterator[tuple[str, object]]:
    """Yield the fields of a message; a list is one field, as JSON."""
    for name, field in value.items():
        if isinstance(field, Mapping):
            yield from _flat(field, f'{before}{name}.')
        else:
            yield f'{before}{name}', json_text(field) if isinstance(field, list | tuple) else field
