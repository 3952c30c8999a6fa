"""ros2 bag export --format lerobot: its flags, and the dataset that it writes from bags."""

from __future__ import annotations

import os
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.bag.choosing import open_bag
from goalwire.apps.cli.commands.bag.play import selection
from goalwire.apps.cli.framework.lookup import full_name
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.bag.exporting.survey import Layout

_QUIET = {'SVT_LOG': '1', 'HF_DATASETS_DISABLE_PROGRESS_BARS': '1'}
"""Environment variables that keep lerobot's encoder and its progress bars from filling the terminal."""


def add_lerobot_arguments(parser: ArgumentParser) -> None:
    """Add the flags of the format `lerobot`."""
    group = parser.add_argument_group('flags of --format lerobot')
    group.add_argument(
        '--state-topic', metavar='TOPIC', type=_topic, help="The robot's state (default: the joint states)"
    )
    group.add_argument(
        '--action-topic', metavar='TOPIC', type=_topic, help='The commands (default: none, and no actions)'
    )
    group.add_argument(
        '--fps',
        metavar='HZ|TOPIC',
        type=_rate,
        help='Frames a second, or a topic whose rate they take (default: the pictures, or else the state)',
    )
    group.add_argument('--task', metavar='TEXT', default='', help='What the robot does in these bags')
    group.add_argument('--robot-type', metavar='NAME', help='What the dataset says of the robot')
    group.add_argument('--no-video', action='store_true', help='Keep pictures as they are, and not as videos')


def _topic(text: str) -> str:
    return full_name(text, 'topic')


def _rate(text: str) -> int | str:
    if text.isdecimal() and int(text):
        return int(text)
    if text.startswith('/'):
        return _topic(text)
    raise ArgumentTypeError(f"'{text}' is neither a whole number above 0 nor a topic, such as /camera")


def export_dataset(arguments: Namespace) -> Outcome:
    """Write a dataset with an episode for each bag."""
    from goalwire.apps.bag.exporting.lerobot_dataset import Target, write_dataset
    from goalwire.apps.bag.exporting.survey import Choice

    for variable, value in _QUIET.items():
        os.environ.setdefault(variable, value)
    paths = arguments.bag_path
    choice = Choice(
        state=arguments.state_topic,
        action=arguments.action_topic,
        fps=arguments.fps,
        wants=selection(arguments).wants,
        names=tuple(arguments.remap),
    )
    target = Target(
        folder=Path(arguments.output or f'{Path(paths[0]).stem}_lerobot'),
        task=arguments.task,
        robot_type=arguments.robot_type,
        has_videos=not arguments.no_video,
    )
    dataset = write_dataset(
        paths, lambda path: open_bag(arguments, path), choice, target, arguments.start_offset
    )
    for path, count in zip(paths, dataset.counts, strict=True):
        tell(f"'{path}': {count:,} frames")
    tell(
        f"'{target.folder}' has {len(paths):,} episodes with {sum(dataset.counts):,} frames, "
        f'{dataset.layout.fps} a second: {_describe(dataset.layout)}'
    )
    for reason in (*dataset.left_out, *dataset.stale):
        tell(reason)
    return Outcome.FAILED if dataset.left_out else Outcome.OK


def _describe(layout: Layout) -> str:
    vectors = (f'{vector.feature} ({len(vector.names)})' for vector in layout.vectors)
    cameras = (f'{camera.feature} ({camera.width} x {camera.height})' for camera in layout.cameras)
    return ', '.join((*vectors, *cameras))
