"""ros2 bag info and list: what a bag contains, and which formats there are."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Callable
from datetime import datetime
from typing import TYPE_CHECKING

from goalwire.apps.bag.selection import service_of
from goalwire.apps.cli.commands.bag.choosing import bag_argument, open_bag
from goalwire.apps.cli.framework.output import tell
from goalwire.observe.sizes import size_text
from goalwire.rosbag2.model import SUFFIXES

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Json, Output
    from goalwire.rosbag2.model import Topic
    from goalwire.rosbag2.reader import Reader


_S = 1_000_000_000
_STORAGES = {name: f'Files that end with {suffix}' for suffix, name in SUFFIXES.items()}
_ZSTD = {'zstd': 'Files that are compressed when they are closed, or messages one by one'}
PLUGINS = {
    'storage': _STORAGES,
    'converter': {'cdr': 'The only serialization format'},
    'compressor': _ZSTD,
    'decompressor': _ZSTD,
}
_SORTED_BY: dict[str, Callable[[tuple[Topic, int]], tuple[object, ...]]] = {
    'name': lambda row: (row[0].name,),
    'type': lambda row: (row[0].type_name, row[0].name),
    'count': lambda row: (row[1], row[0].name),
}


def add_show_info_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag info`."""
    bag_argument(parser)
    parser.add_argument('-t', '--topic-name', action='store_true', help='Only display topic names')
    parser.add_argument(
        '-v', '--verbose', action='store_true', help='Read all messages, and show the size of each topic, too'
    )
    parser.add_argument('--sort', choices=list(_SORTED_BY), default='name', help='What topics are sorted by')


def show_info(arguments: Namespace, output: Output) -> None:
    """Print facts about the bag."""
    with open_bag(arguments) as bag:
        rows = sorted(
            ((topic, bag.counts[topic.name]) for topic in bag.topics), key=_SORTED_BY[arguments.sort]
        )
        if output.json:
            output.data(_as_json(bag, rows))
        elif arguments.topic_name and not arguments.verbose:
            for topic, _ in rows:
                if not service_of(topic.name):
                    output.line(topic.name)
        else:
            _print(bag, rows, output, _sizes(bag) if arguments.verbose else None)
        for problem in bag.problems:
            tell(f'{problem}; see: ros2 bag check, ros2 bag reindex')


def _sizes(bag: Reader) -> Counter[str]:
    sizes: Counter[str] = Counter()
    for message in bag.messages():
        sizes[message.topic] += len(message.data)
    return sizes


def _print(bag: Reader, rows: list[tuple[Topic, int]], output: Output, sizes: Counter[str] | None) -> None:
    facts = bag.facts
    topics = [row for row in rows if not service_of(row[0].name)]
    services = [row for row in rows if service_of(row[0].name)]
    output.line()
    _field(output, 'Files:', [file.path for file in facts.files])
    _field(output, 'Bag size:', [size_text(bag.size)])
    _field(output, 'Storage id:', [facts.storage])
    _field(output, 'ROS Distro:', [facts.ros_distro or 'unknown'])
    _field(output, 'Duration:', [f'{_seconds(facts.duration)}s'])
    _field(output, 'Start:', [_moment(bag.start)])
    _field(output, 'End:', [_moment(bag.end)])
    _field(output, 'Messages:', [str(sum(count for _, count in topics))])
    _field(output, 'Topic information:', [_topic_line(topic, count, sizes) for topic, count in topics])
    _field(output, 'Services:', [str(len(services))])
    if services:
        _field(output, 'Service information:', [_topic_line(topic, n, sizes) for topic, n in services])
    for key, value in facts.custom_data:
        _field(output, 'Custom data:', [f'{key}={value}'])


def _field(output: Output, title: str, lines: list[str]) -> None:
    """Print a title, and the lines in a column beside it."""
    for position, line in enumerate(lines or ['']):
        output.line(f'{"" if position else title:<19}{" " if len(title) > 18 else ""}{line}'.rstrip())


def _topic_line(topic: Topic, count: int, sizes: Counter[str] | None) -> str:
    service = service_of(topic.name)
    parts = [
        f'Service: {service}' if service else f'Topic: {topic.name}',
        f'Type: {topic.type_name.removesuffix("_Event") if service else topic.type_name}',
        f'{"Event Count" if service else "Count"}: {count}',
        f'Serialization Format: {topic.serialization}',
    ]
    if sizes is not None:
        parts.insert(3, f'Size Contribution: {size_text(sizes[topic.name])}')
    return ' | '.join(parts)


def _seconds(nanoseconds: int) -> str:
    return f'{nanoseconds // _S}.{nanoseconds % _S:09}'


def _moment(nanoseconds: int) -> str:
    local = datetime.fromtimestamp(nanoseconds // _S).astimezone()
    date = f'{local:%b} {local.day:>2} {local:%Y %H:%M:%S}'
    return f'{date}.{nanoseconds % _S:09} ({_seconds(nanoseconds)})'


def _as_json(bag: Reader, rows: list[tuple[Topic, int]]) -> Json:
    facts = bag.facts
    return {
        'path': bag.path,
        'storage': facts.storage,
        'ros_distro': facts.ros_distro,
        'start': facts.start,
        'duration': facts.duration,
        'size': bag.size,
        'messages': facts.count,
        'files': [
            {'path': f.path, 'start': f.start, 'duration': f.duration, 'messages': f.count}
            for f in facts.files
        ],
        'topics': [
            {
                'name': topic.name,
                'type': topic.type_name,
                'type_hash': topic.type_hash,
                'messages': count,
                'qos': [
                    {'reliability': q.reliability.short_key, 'durability': q.durability.short_key}
                    for q in topic.qos
                ],
            }
            for topic, count in rows
        ],
        'custom_data': dict(facts.custom_data),
        'problems': bag.problems,
    }


def add_list_plugins_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag list`."""
    parser.add_argument('plugin_type', choices=list(PLUGINS), help='Which plugins to list')
    parser.add_argument('-v', '--verbose', action='store_true', help='Describe each plugin, too')


def list_plugins(arguments: Namespace, output: Output) -> None:
    """Print the names of the plugins."""
    if arguments.verbose and not output.json:
        output.line(f'available {arguments.plugin_type} plugins are:')
    for name, text in PLUGINS[arguments.plugin_type].items():
        if output.json:
            output.data({'name': name, 'description': text})
        elif arguments.verbose:
            output.line(f'name: {name}')
            output.line(f'\t{text}')
        else:
            output.line(name)
