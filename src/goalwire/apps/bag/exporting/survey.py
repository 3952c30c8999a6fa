"""Finds the features of a dataset of several bags: the names of its numbers and the sizes of its pictures.

A dataset has the same features in every episode. So all bags are looked through before the first frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice, pairwise
from statistics import median

from goalwire.apps.bag.exporting.colours import colours_of
from goalwire.apps.bag.exporting.numbers import JOINT_STATE, reader_of
from goalwire.apps.bag.exporting.pictures import COMPRESSED, IMAGE
from goalwire.errors import BagError
from goalwire.files import show
from goalwire.records import record
from goalwire.rosbag2.model import Topic
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.types import class_of

STATE, ACTION, PICTURES = 'observation.state', 'action', 'observation.images'
"""LeRobot's names of features."""
_TIMED = 300
"""The rate of a topic is taken from this many messages."""
_TRIED = 20
"""This many pictures of a topic are tried at most to find one that can be used."""


@record
class Choice:
    """The choices of the user. `Survey` chooses each topic that is None here."""

    state: str | None = None
    action: str | None = None
    """The topic of the commands; None for a dataset without actions."""
    fps: int | str | None = None
    """Frames a second, or a topic whose rate they take."""
    wants: Callable[[str, str], bool] = lambda _topic, _type: True
    """Returns whether a topic of pictures, given its name and its type, is chosen."""
    names: tuple[tuple[str, str], ...] = ()
    """Other names of topics, from which features of pictures get their names."""


@record
class Vector:
    """A feature of numbers: the topic that they come from, and their names."""

    feature: str
    topic: str
    names: tuple[str, ...]


@record
class Camera:
    """A feature of pictures: the topic that they come from, and their size."""

    feature: str
    topic: str
    height: int
    width: int


@record
class Layout:
    """The features of a dataset, and how many frames a second it has."""

    fps: int
    vectors: tuple[Vector, ...]
    cameras: tuple[Camera, ...]

    @property
    def topics(self) -> list[str]:
        """The topics that the features come from."""
        return [*(vector.topic for vector in self.vectors), *(camera.topic for camera in self.cameras)]


class Survey:
    """Looks through bags, and tells the layout of a dataset of them."""

    def __init__(self, choice: Choice) -> None:
        self._choice = choice
        self._state = choice.state or ''
        self._names: dict[str, dict[str, None]] = {}
        """The names of the numbers, in the order of their first appearance, by topic."""
        self._sizes: dict[str, tuple[int, int]] = {}
        self._fps = choice.fps if isinstance(choice.fps, int) else 0
        self.unusable: dict[str, str] = {}
        """Topics of pictures that the dataset does not have, each with the reason."""

    def look(self, bag: Reader) -> None:
        """Look through a bag. The first one decides which topics are used.

        Raises BagError, InterfaceError, DecodeError.
        """
        is_first = not self._names
        if is_first:
            self._state = self._state or self._find_state(bag)
        for name in dict.fromkeys((self._state, self._choice.action or self._state)):
            self._look_at_numbers(bag, _topic_of(bag, name))
        if is_first:
            for topic in bag.topics:
                if topic.type_name in {IMAGE, COMPRESSED} and self._choice.wants(topic.name, topic.type_name):
                    self._look_at_pictures(bag, topic.name)
            self._fps = self._fps or self._find_rate(bag)

    def layout(self) -> Layout:
        """Return the layout of the bags that were looked through, at least one."""
        vectors = [Vector(STATE, self._state, tuple(self._names[self._state]))]
        if self._choice.action is not None:
            vectors.append(Vector(ACTION, self._choice.action, tuple(self._names[self._choice.action])))
        features = self._camera_names()
        cameras = (Camera(features[topic], topic, *size) for topic, size in self._sizes.items())
        return Layout(self._fps, tuple(vectors), tuple(cameras))

    def _find_state(self, bag: Reader) -> str:
        """Return the topic of the joints' states."""
        found = [
            topic.name
            for topic in bag.topics
            if topic.type_name == JOINT_STATE and topic.name != self._choice.action and bag.counts[topic.name]
        ]
        if len(found) == 1 or '/joint_states' in found:
            return found[0] if len(found) == 1 else '/joint_states'
        if not found:
            raise BagError(
                f"'{show(bag.path)}' has no messages of {JOINT_STATE}; name the topic that has "
                f"the robot's state by --state-topic"
            )
        raise BagError(
            f"'{show(bag.path)}' has several topics of {JOINT_STATE}: {', '.join(map(show, found))}; "
            f'name one by --state-topic'
        )

    def _look_at_numbers(self, bag: Reader, topic: Topic) -> None:
        read = reader_of(topic.type_name, class_of(topic, bag.topics))
        names = self._names.setdefault(topic.name, {})
        for _, message in bag.decoded([topic.name]):
            names.update(dict.fromkeys(read(message)))
        if not names:
            raise BagError(
                f"'{show(bag.path)}' has no numbers on '{show(topic.name)}', of the type {topic.type_name}"
            )

    def _look_at_pictures(self, bag: Reader, topic: str) -> None:
        for _, picture in islice(bag.decoded([topic]), _TRIED):
            try:
                height, width, _ = colours_of(picture).shape
            except ValueError as error:
                self.unusable[topic] = str(error)
            else:
                self.unusable.pop(topic, None)
                self._sizes[topic] = height, width
                return

    def _find_rate(self, bag: Reader) -> int:
        """Return the rate of the chosen topic; of the first pictures, if none is chosen, or of the state."""
        topic = self._choice.fps
        if not isinstance(topic, str):
            topic = next(iter(self._sizes), self._state)
        _topic_of(bag, topic)
        times = (message.time for message in islice(bag.messages([topic]), _TIMED))
        waits = [later - earlier for earlier, later in pairwise(times)]
        if not waits or not median(waits):
            raise BagError(
                f"'{show(topic)}' in '{show(bag.path)}' has too few messages to take a rate from; "
                f'give the frames a second by --fps'
            )
        return max(1, round(1e9 / median(waits)))

    def _camera_names(self) -> dict[str, str]:
        """Return a unique feature for each topic of pictures: the topic's name, with _ for each /."""
        features: dict[str, str] = {}
        renamed = dict(self._choice.names)
        for topic in self._sizes:
            name = renamed.get(topic, topic).strip('/').replace('/', '_')
            features[topic] = next(
                feature for feature in _numbered(f'{PICTURES}.{name}') if feature not in features.values()
            )
        return features


def _topic_of(bag: Reader, name: str) -> Topic:
    """Return a topic that has messages; raises BagError if the bag has none of it."""
    for topic in bag.topics:
        if topic.name == name and bag.counts[name]:
            return topic
    raise BagError(f"'{show(bag.path)}' has no messages of '{show(name)}'")


def _numbered(name: str) -> Iterator[str]:
    yield name
    number = 2
    while True:
        yield f'{name}_{number}'
        number += 1
