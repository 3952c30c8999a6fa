"""ros2 bag record: record topics, services and actions until Ctrl-C."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, ArgumentTypeError, Namespace, _ArgumentGroup
from contextlib import nullcontext, suppress
from datetime import datetime
from time import monotonic
from typing import TYPE_CHECKING

from goalwire.apps.bag.options import CACHE_BYTES, RecordOptions
from goalwire.apps.bag.selection import Names, Selection
from goalwire.apps.cli.commands.bag.choosing import (
    add_name_arguments,
    add_regex_arguments,
    names,
)
from goalwire.apps.cli.framework.lookup import full_name
from goalwire.apps.cli.framework.numbers import count, length
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.observe.sizes import size_text
from goalwire.rosbag2.writer import PRESETS, STORAGES, Writer

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.bag.recorder import Recorder
    from goalwire.apps.cli.framework.output import Output

NODE_NAME = 'rosbag2_recorder'
LOOK_S = 1.0
"""Seconds between two checks for new topics and lost messages."""
TELL_S = 60.0
"""Seconds between two lines with the number of recorded messages."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag record`."""
    _add_choice(parser)
    _add_output(parser)
    group = parser.add_argument_group('how it records')
    group.add_argument(
        '--include-unpublished-topics', action='store_true', help='Record topics without a publisher, too'
    )
    group.add_argument('--include-hidden-topics', action='store_true', help='Record hidden topics, too')
    group.add_argument(
        '--ignore-leaf-topics', action='store_true', help='Leave topics out that nobody subscribes to'
    )
    group.add_argument(
        '--no-discovery', action='store_true', help='Record only the topics that exist at the start'
    )
    group.add_argument(
        '-p',
        '--polling-interval',
        metavar='MS',
        type=length,
        help='Accepted as in ROS 2: new topics are noticed at once',
    )
    group.add_argument(
        '--qos-profile-overrides-path', metavar='FILE', help='YAML: the QoS to subscribe with, by topic'
    )
    group.add_argument(
        '--max-cache-size',
        metavar='BYTES',
        type=length,
        default=CACHE_BYTES,
        help=f'Most bytes that wait for the file, or that a snapshot keeps (default: {CACHE_BYTES})',
    )
    group.add_argument(
        '--max-cache-duration',
        metavar='S',
        type=length,
        default=0,
        help='Most seconds of messages that a snapshot keeps',
    )
    group.add_argument(
        '--start-paused', action='store_true', help='Start paused: the service ~/resume begins the recording'
    )
    group.add_argument(
        '--disable-keyboard-controls', action='store_true', help='Accepted as in ROS 2: it reads no keys'
    )
    group.add_argument('--use-sim-time', action='store_true', help='Give messages the time of /clock')
    group.add_argument('--node-name', default=NODE_NAME, help=f'Name of the node (default: {NODE_NAME})')
    _add_snapshots(group)


def _add_snapshots(group: _ArgumentGroup) -> None:
    group.add_argument(
        '--snapshot-mode',
        action='store_true',
        help='Keep messages in memory, and write them when the service ~/snapshot is called',
    )
    group.add_argument(
        '--snapshot-on-abort',
        action='store_true',
        help='Snapshot mode, which also writes when a goal of any action is aborted',
    )
    group.add_argument(
        '--repeat-transient-local',
        metavar='TOPIC[=N]',
        nargs='+',
        type=_parse_repeat,
        default=[],
        help='Topics whose latest messages are repeated at the start of each file, like /tf_static',
    )


def _add_choice(parser: ArgumentParser) -> None:
    group = parser.add_argument_group('what it records')
    group.add_argument('topic_names', metavar='TOPIC', nargs='*', help='Topics to record')
    group.add_argument('-a', '--all', action='store_true', help='Record all topics, services and actions')
    add_name_arguments(group, 'Record', has_all=True)
    group.add_argument(
        '--topic-types', metavar='TYPE', nargs='+', default=[], help='Record topics of these types'
    )
    group.add_argument(
        '--exclude-topic-types', metavar='TYPE', nargs='+', default=[], help='Leave topics of these types out'
    )
    add_regex_arguments(group, 'Record')


def _add_output(parser: ArgumentParser) -> None:
    group = parser.add_argument_group('where it writes')
    group.add_argument(
        '-o', '--output', metavar='FOLDER', help='Folder to make (default: rosbag2_ and the time)'
    )
    group.add_argument(
        '-s', '--storage', choices=STORAGES, default='mcap', help='Kind of the files (default: mcap)'
    )
    group.add_argument(
        '--storage-preset-profile',
        choices=PRESETS,
        default='none',
        help='How MCAP compresses (default: none)',
    )
    group.add_argument(
        '-f', '--serialization-format', choices=['', 'cdr'], default='', help='Accepted as in ROS 2'
    )
    group.add_argument(
        '-b',
        '--max-bag-size',
        metavar='BYTES',
        type=length,
        default=0,
        help='Begin a new file after this size',
    )
    group.add_argument(
        '-d',
        '--max-bag-duration',
        metavar='S',
        type=length,
        default=0,
        help='Begin a new file after this time',
    )
    group.add_argument(
        '--max-bag-files',
        metavar='N',
        type=length,
        default=0,
        help='Remove the oldest file if there are more',
    )
    group.add_argument(
        '--compression-mode',
        choices=['none', 'file', 'message'],
        default='none',
        help='file: compress each file when it is closed; message: each message, in sqlite3 (default: none)',
    )
    group.add_argument('--compression-format', choices=['', 'zstd'], default='', help='zstd is the only one')
    group.add_argument('--compression-queue-size', metavar='N', type=length, help='Accepted as in ROS 2')
    group.add_argument('--compression-threads', metavar='N', type=length, help='Accepted as in ROS 2')
    group.add_argument('--compression-threads-priority', metavar='N', help='Accepted as in ROS 2')
    group.add_argument(
        '--custom-data',
        metavar='KEY=VALUE',
        nargs='*',
        type=_key_value,
        default=[],
        help='Text to keep in the metadata',
    )


def _key_value(text: str) -> tuple[str, str]:
    key, found, value = text.partition('=')
    if not (key and found):
        raise ArgumentTypeError(f"'{text}' is not of the form KEY=VALUE")
    return key, value


def _parse_repeat(text: str) -> tuple[str, int]:
    topic, _, depth = text.partition('=')
    return full_name(topic, 'topic'), count(depth) if depth else 1


def _selection(arguments: Namespace) -> Selection:
    selection = Selection(
        Names(
            arguments.all or arguments.all_topics,
            names([*arguments.topics, *arguments.topic_names], 'topic'),
            names(arguments.exclude_topics, 'topic'),
        ),
        Names(
            arguments.all or arguments.all_services,
            names(arguments.services, 'service'),
            names(arguments.exclude_services, 'service'),
        ),
        Names(
            arguments.all or arguments.all_actions,
            names(arguments.actions, 'action'),
            names(arguments.exclude_actions, 'action'),
        ),
        frozenset(arguments.topic_types),
        frozenset(arguments.exclude_topic_types),
        arguments.regex,
        arguments.exclude_regex,
        arguments.include_hidden_topics,
    )
    kinds = (selection.topics, selection.services, selection.actions)
    if not any(kind.all or kind.some for kind in kinds) and not selection.types and not selection.regex:
        raise CommandError(
            Outcome.USAGE, f'{arguments.prog}: nothing is chosen', 'name topics, or give -a for all there are'
        )
    return selection


def _check(arguments: Namespace) -> None:
    """Raise CommandError for flags that do not go together."""
    splits = arguments.max_bag_size or arguments.max_bag_duration
    if arguments.max_bag_files and not splits:
        raise CommandError(
            Outcome.USAGE, f'{arguments.prog}: --max-bag-files needs splits', 'give -b or -d as well'
        )
    if arguments.compression_mode == 'message' and arguments.storage != 'sqlite3':
        raise CommandError(
            Outcome.USAGE,
            f'{arguments.prog}: the storage {arguments.storage} cannot compress messages one by one',
            'give --storage sqlite3 as well, or --storage-preset-profile zstd_fast instead',
        )


def run(arguments: Namespace, output: Output) -> Outcome:  # noqa: ARG001 - it prints no data
    """Record until Ctrl-C or SIGTERM; either is the normal end, with the outcome OK."""
    from goalwire.apps.bag.aborted_goals import snapshots_of_aborts
    from goalwire.apps.bag.recorder import Recorder
    from goalwire.apps.bag.recorder_services import offer_services
    from goalwire.apps.cli.framework.live import live

    _check(arguments)
    selection = _selection(arguments)
    options = RecordOptions(
        cache_bytes=arguments.max_cache_size or CACHE_BYTES,
        snapshot=arguments.snapshot_mode or arguments.snapshot_on_abort,
        snapshot_s=arguments.max_cache_duration,
        repeat=tuple(arguments.repeat_transient_local),
        discovery=not arguments.no_discovery,
        unpublished=arguments.include_unpublished_topics,
        ignore_leaves=arguments.ignore_leaf_topics,
        qos=_qos_overrides(arguments.qos_profile_overrides_path),
        sim_time=arguments.use_sim_time,
        paused=arguments.start_paused,
    )
    bag = _new_bag(arguments)
    on_abort = arguments.snapshot_on_abort

    async def record(node: goalwire.Node) -> Outcome:
        async with (
            Recorder(node, bag, selection, options) as recorder,
            snapshots_of_aborts(recorder) if on_abort else nullcontext(),
        ):
            offer_services(recorder)
            tell(f"recording into '{bag.path}'{'; it is paused' if options.paused else ''}; Ctrl-C ends it")
            with suppress(asyncio.CancelledError):  # by a signal: the normal end of a recording
                await _tell_of(recorder)
        _tell_end(recorder)
        return Outcome.OK

    try:
        return live(record, arguments.node_name, use_sim_time=arguments.use_sim_time)
    finally:
        bag.close()


def _qos_overrides(path: str | None) -> tuple[tuple[str, goalwire.QoS], ...]:
    if path is None:
        return ()
    from goalwire.apps.bag.qos_overrides import read_qos_overrides

    return tuple(read_qos_overrides(path).items())


def _new_bag(arguments: Namespace) -> Writer:
    folder = arguments.output or f'rosbag2_{datetime.now().astimezone():%Y_%m_%d-%H_%M_%S}'
    return Writer(
        folder,
        storage=arguments.storage,
        preset=arguments.storage_preset_profile,
        max_bytes=arguments.max_bag_size,
        max_duration=arguments.max_bag_duration,
        max_files=arguments.max_bag_files,
        compress_files=arguments.compression_mode == 'file',
        compress_messages=arguments.compression_mode == 'message',
        custom_data=dict(arguments.custom_data),
    )


async def _tell_of(recorder: Recorder) -> None:
    """Print new topics and lost messages at once, and the number of recorded messages from time to time."""
    known: set[str] = set()
    lost, told, start = 0, monotonic(), monotonic()
    while True:
        for topic in recorder.topics:
            if topic not in known:
                known.add(topic)
                tell(f"recording '{topic}'")
        losses = recorder.losses.dropped.copy() + recorder.losses.missed.copy()
        if losses.total() > lost:
            worst = ', '.join(f'{topic}: {n:,}' for topic, n in losses.most_common(3))
            tell(f'{losses.total() - lost:,} messages were lost since the last look; in all {worst}')
            lost = losses.total()
        if monotonic() - told >= TELL_S:
            told = monotonic()
            tell(
                f'{told - start:.0f} s: {recorder.count:,} messages, {size_text(recorder.byte_count)}, '
                f'{len(known)} topics, {lost:,} lost'
            )
        try:
            async with asyncio.timeout(LOOK_S):
                await recorder.wait()
        except TimeoutError:
            pass


def _tell_end(recorder: Recorder) -> None:
    bag = recorder.bag
    tell(f"'{bag.path}' has {bag.count:,} messages of {len(recorder.topics)} topics")
    dropped, missed = recorder.losses
    for what, lost in (('dropped, since the disk did not keep up', dropped), ('lost on their way', missed)):
        if lost.total():
            each = ', '.join(f'{topic}: {n:,}' for topic, n in lost.most_common() if n)
            tell(f'{lost.total():,} messages were {what}: {each}')
