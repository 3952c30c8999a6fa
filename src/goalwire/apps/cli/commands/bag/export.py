"""ros2 bag export: the messages of a bag as CSV, a file for each topic, or as JSON lines."""

from __future__ import annotations

import csv
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.commands.bag.play import add_choice, selection
from goalwire.apps.cli.commands.bag.reading import bag_argument, open_bag
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import json_text, tell
from goalwire.observe.messages import as_dict

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add what `bag export` takes."""
    bag_argument(parser)
    parser.add_argument(
        '--format', choices=('csv', 'jsonl'), default='csv', help='What to write (default: csv)'
    )
    parser.add_argument(
        '-o', '--output', metavar='PATH', help='Folder of the CSV files, or file of the JSON lines'
    )
    add_choice(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Write it; JSON lines go to standard output if no file is named."""
    with open_bag(arguments) as bag:
        chosen = selection(arguments)
        topics = [topic.name for topic in bag.topics if chosen.wants(topic.name, topic.type_name)]
        start = bag.start + int(arguments.start_offset * 1e9)
        rows = ((message, as_dict(decoded)) for message, decoded in bag.decoded(topics, start))
        if arguments.format == 'csv':
            _write_csv(rows, Path(arguments.output or f'{Path(bag.path).stem}_csv'))
            return
        if arguments.output:
            with Path(arguments.output).open('x', encoding='utf-8') as file:
                file.writelines(json_text(_line(message, value)) + '\n' for message, value in rows)
            return
        for message, value in rows:
            output.data(_line(message, value))


def _line(message: Any, value: Any) -> dict[str, Any]:
    return {'topic': message.topic, 'time': message.time, 'sent': message.sent, 'message': value}


def _write_csv(rows: Iterator[tuple[Any, Any]], folder: Path) -> None:
    """Write a file for each topic: a column for each field, those of nested messages as `pose.x`."""
    if folder.exists():
        raise CommandError(Outcome.FAILED, f"'{folder}' exists already", 'choose another folder with -o')
    folder.mkdir(parents=True)
    counts: dict[Path, int] = {}
    with ExitStack() as stack:
        writers: dict[str, tuple[Path, Any]] = {}
        for message, value in rows:
            fields = dict(_flat(value))
            if message.topic not in writers:
                path = folder / f'{message.topic.strip("/").replace("/", "__")}.csv'
                file = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
                writers[message.topic] = path, csv.writer(file)
                writers[message.topic][1].writerow(['time', 'sent', *fields])
            path, writer = writers[message.topic]
            writer.writerow([message.time, message.sent, *fields.values()])
            counts[path] = counts.get(path, 0) + 1
    for path, count in counts.items():
        tell(f"'{path}' has {count:,} rows")


def _flat(value: Mapping[str, Any], before: str = '') -> Iterator[tuple[str, object]]:
    """Yield the fields of a message; a list is one field, as JSON."""
    for name, field in value.items():
        if isinstance(field, Mapping):
            yield from _flat(field, f'{before}{name}.')
        else:
            yield f'{before}{name}', json_text(field) if isinstance(field, list | tuple) else field
