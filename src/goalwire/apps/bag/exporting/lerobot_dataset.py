"""Bags as a dataset of LeRobot, an episode for each bag, written by the package `lerobot` itself.

LeRobot's format changes from version to version, and its package writes the one that it also reads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from goalwire.apps.bag.exporting.folders import refuse_existing
from goalwire.apps.bag.exporting.frames import Episode
from goalwire.apps.bag.exporting.survey import Choice, Layout, Survey
from goalwire.errors import BagError
from goalwire.files import show
from goalwire.records import record
from goalwire.rosbag2.reader import Reader

TASK_KEY = 'task'
"""The key of the task's text in a bag's custom data."""
SMALLEST = 32
"""The fewest pixels that a side of a video has: lerobot's encoder, SVT-AV1, kills the process at 16."""


@record
class Target:
    """Where the dataset is written to, and what it says of its episodes."""

    folder: Path
    task: str = ''
    """The task of the robot; '' to take it from each bag's custom data, or else the folder's name."""
    robot_type: str | None = None
    has_videos: bool = True
    """False to keep the pictures as they are, and not as videos, which lose details."""


@record
class Dataset:
    """A dataset that was written."""

    layout: Layout
    counts: tuple[int, ...]
    """The number of frames of each episode."""
    left_out: tuple[str, ...]
    """Why pictures are not in the dataset: a sentence for each reason."""
    stale: tuple[str, ...]
    """A sentence for each camera of an episode that sent nothing for a while."""


def write_dataset(
    paths: Sequence[str], open_bag: Callable[[str], Reader], choice: Choice, target: Target, offset: float
) -> Dataset:
    """Write a dataset with an episode for each bag, from `offset` s after its start.

    If a bag cannot be read, the episodes before it stay in the dataset. Raises BagError (also if lerobot is
    missing), InterfaceError, DecodeError and OSError.
    """
    if find_spec('lerobot') is None:
        raise BagError("a dataset of LeRobot needs the package 'lerobot'; run: pip install lerobot")
    refuse_existing(target.folder)
    survey = Survey(choice)
    for path in paths:
        with open_bag(path) as bag:
            survey.look(bag)
    layout = survey.layout()
    _check_sizes(layout, target)
    dataset = _create(layout, target)
    counts: list[int] = []
    left_out = [f"'{topic}' is left out: {reason}" for topic, reason in survey.unusable.items()]
    stale: list[str] = []
    try:
        for path in paths:
            with open_bag(path) as bag:
                episode = Episode(bag, layout, bag.start + int(offset * 1e9))
                counts.append(_write_episode(dataset, episode, _task_of(bag, target)))
            left_out += [f"'{path}': {reason}" for reason in episode.left_out()]
            stale += [f"'{path}': {reason}" for reason in episode.stale()]
    finally:
        dataset.finalize()
    return Dataset(layout, tuple(counts), tuple(left_out), tuple(stale))


def features_of(layout: Layout, *, has_videos: bool) -> dict[str, dict[str, Any]]:
    """Return the features in LeRobot's words."""
    features: dict[str, dict[str, Any]] = {}
    for vector in layout.vectors:
        features[vector.feature] = {
            'dtype': 'float32',
            'shape': (len(vector.names),),
            'names': list(vector.names),
        }
    for camera in layout.cameras:
        features[camera.feature] = {
            'dtype': 'video' if has_videos else 'image',
            'shape': (camera.height, camera.width, 3),
            'names': ['height', 'width', 'channels'],
        }
    return features


def _check_sizes(layout: Layout, target: Target) -> None:
    """Raise BagError for pictures that are too small for videos."""
    for camera in layout.cameras:
        if target.has_videos and min(camera.height, camera.width) < SMALLEST:
            raise BagError(
                f"'{show(camera.topic)}' has pictures of {camera.width} x {camera.height}, and videos need "
                f'{SMALLEST} x {SMALLEST}; use --no-video'
            )


def _create(layout: Layout, target: Target) -> Any:
    """Return a new, empty LeRobotDataset."""
    try:
        library = import_module('lerobot.datasets.lerobot_dataset')
    except ImportError as error:
        raise BagError(
            f'the package lerobot cannot be used ({error}); a dataset needs lerobot 0.4 or newer, '
            f'run: pip install -U lerobot'
        ) from error
    return library.LeRobotDataset.create(
        repo_id=target.folder.name,
        fps=layout.fps,
        features=features_of(layout, has_videos=target.has_videos),
        root=target.folder,
        robot_type=target.robot_type,
        use_videos=target.has_videos,
    )


def _write_episode(dataset: Any, episode: Episode, task: str) -> int:
    count = 0
    for frame in episode.frames():
        dataset.add_frame({**frame, 'task': task})
        count += 1
    dataset.save_episode()
    return count


def _task_of(bag: Reader, target: Target) -> str:
    return target.task or dict(bag.facts.custom_data).get(TASK_KEY) or target.folder.name
