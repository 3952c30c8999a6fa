"""ros2 bag convert: merge, cut, filter, rename and compress bags."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from goalwire.apps.bag.rewriting import Cut, open_all, rewrite
from goalwire.apps.bag.selection import Names, Selection
from goalwire.apps.cli.commands.bag.play import add_choice, selection
from goalwire.apps.cli.framework.numbers import length, seconds
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.files import LARGEST_PARAMETER_FILE, read_regular
from goalwire.rosbag2.writer import PRESETS, STORAGES, Writer

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.rosbag2.reader import Reader

_KEYS = {'max_bagfile_size': 'max_bytes', 'max_bagfile_duration': 'max_duration'}


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag convert`."""
    parser.add_argument(
        '-i',
        '--input',
        metavar=('BAG', 'STORAGE'),
        nargs='+',
        action='append',
        required=True,
        help='Bag to read; several are merged',
    )
    parser.add_argument(
        '-o',
        '--output-options',
        '--output',
        metavar='FILE|FOLDER',
        required=True,
        help='YAML file with `output_bags`, as in ROS 2; or the folder of one bag, which the flags shape',
    )
    add_choice(parser)
    parser.add_argument(
        '--playback-duration', metavar='S', type=seconds, default=-1.0, help='Copy only S seconds'
    )
    parser.add_argument(
        '--output-storage', choices=STORAGES, default='mcap', help='Kind of the files (default: mcap)'
    )
    parser.add_argument(
        '--storage-preset-profile', choices=PRESETS, default='none', help='How MCAP compresses'
    )
    parser.add_argument(
        '-b',
        '--max-bag-size',
        metavar='BYTES',
        type=length,
        default=0,
        help='Begin a new file after this size',
    )


def run(arguments: Namespace, output: Output) -> None:
    """Write the bags, and print the content of each."""
    with ExitStack() as stack:
        sources = open_all((each[0] for each in arguments.input), stack)
        target = arguments.output_options
        if Path(target).suffix in {'.yaml', '.yml'}:
            for entry in _entries(target):
                _write(sources, _target(entry), Cut(_selection(entry)), output)
            return
        start = min(source.start for source in sources) + int(arguments.start_offset * 1e9)
        duration = arguments.playback_duration
        cut = Cut(
            selection(arguments),
            start if arguments.start_offset else None,
            start + int(duration * 1e9) + 1 if duration >= 0 else None,
            tuple(arguments.remap),
        )
        bag = Writer(
            target,
            storage=arguments.output_storage,
            preset=arguments.storage_preset_profile,
            max_bytes=arguments.max_bag_size,
        )
        _write(sources, bag, cut, output)


def _write(sources: list[Reader], bag: Writer, cut: Cut, output: Output) -> None:
    with bag:
        count = rewrite(sources, bag, cut)
    output.line(f"'{bag.path}' has {count:,} messages")


def _entries(path: str) -> list[Mapping[str, Any]]:
    import yaml

    try:
        found = yaml.safe_load(read_regular(path, LARGEST_PARAMETER_FILE))
    except yaml.YAMLError as error:
        raise CommandError(
            Outcome.BAD_VALUE, f'{path}: it is not YAML: {" ".join(str(error).split())}'
        ) from None
    entries = found.get('output_bags') if isinstance(found, Mapping) else None
    if not isinstance(entries, list) or not all(isinstance(e, Mapping) and e.get('uri') for e in entries):
        raise CommandError(Outcome.BAD_VALUE, f'{path}: it has no list `output_bags`, each with a `uri`')
    return entries


def _target(entry: Mapping[str, Any]) -> Writer:
    splits = {ours: entry[theirs] for theirs, ours in _KEYS.items() if entry.get(theirs)}
    return Writer(
        str(entry['uri']),
        storage=entry.get('storage_id') or 'mcap',
        preset=entry.get('storage_preset_profile') or 'none',
        compress_files=str(entry.get('compression_mode')).lower() == 'file',
        compress_messages=str(entry.get('compression_mode')).lower() == 'message',
        **splits,
    )


def _selection(entry: Mapping[str, Any]) -> Selection:
    """Return the choice for an output bag, by the keys of rosbag2's record options."""
    kinds = {
        kind: Names(
            bool(entry.get('all') or entry.get(f'all_{kind}')),
            frozenset(entry.get(kind) or ()),
            frozenset(entry.get(f'exclude_{kind}') or ()),
        )
        for kind in ('topics', 'services', 'actions')
    }
    return Selection(
        kinds['topics'],
        kinds['services'],
        kinds['actions'],
        types=frozenset(entry.get('topic_types') or ()),
        types_out=frozenset(entry.get('exclude_topic_types') or ()),
        regex=entry.get('regex') or '',
        regex_out=entry.get('exclude_regex') or '',
        hidden=bool(entry.get('include_hidden_topics')),
    )
