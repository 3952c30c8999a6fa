"""A bag for the page: its content and its goals. It has no node, so nothing can be sent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from goalwire.apps.console.state.robot_watch import namespaces
from goalwire.errors import BagError, DecodeError, InterfaceError, peer_text
from goalwire.observe.goals import GoalTable, read_reported_goals
from goalwire.rosbag2.model import Topic
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.types import decoder_of

STATUS, FEEDBACK = '/_action/status', '/_action/feedback'
_MOST_GOALS = 2000
UNREADABLE = (BagError, DecodeError, InterfaceError)
"""The errors for broken bytes, and for unusable definitions of types."""


class Recording:
    """The bag that all pages share. Times in s are counted from its start."""

    def __init__(self, path: str) -> None:
        """Read the bag's index; raises BagError, OSError."""
        self.path = path
        with Reader(path) as bag:
            self.topics: dict[str, Topic] = {topic.name: topic for topic in bag.topics}
            self.counts = bag.counts
            self.start, self.end = bag.start, bag.end
            self.problems = bag.problems
        if not any(self.counts.values()):
            raise BagError(f"the bag '{path}' has no messages: there is nothing to show")
        self.robots = namespaces(
            [(topic.name, [topic.type_name]) for topic in self.topics.values() if self.counts[topic.name]]
        )

    @property
    def duration(self) -> float:
        """The length of the recording, in s."""
        return (self.end - self.start) / 1e9

    def seconds(self, time: int) -> float:
        """Return a time of the bag, in ns since 1970, as s since its start."""
        return (time - self.start) / 1e9

    def read_goals(self) -> GoalTable:
        """Read the goals of every action whose status or feedback was recorded."""
        goals = GoalTable(kept=_MOST_GOALS)
        names = [name for name in self.topics if name.endswith((STATUS, FEEDBACK)) and self.counts[name]]
        if not names:
            return goals
        decoders = Decoders(self.topics)
        with Reader(self.path) as bag:
            for message in bag.messages(names):
                value = decoders.decode(message.topic, message.data)
                if value is not None:
                    self._take(goals, message.topic, value, self.seconds(message.time))
        self.problems += decoders.problems.values()
        return goals

    def _take(self, goals: GoalTable, topic: str, value: Any, now: float) -> None:
        if topic.endswith(STATUS):
            # A server with another clock, as a simulation's, accepted its goals long before the bag began.
            reported = [
                goal if goal.accepted * 1e9 >= self.start else goal._replace(accepted=0.0)
                for goal in read_reported_goals(value)
            ]
            goals.take_statuses(topic.removesuffix(STATUS), reported, now, self.start / 1e9)
        else:
            goals.take_feedback(
                topic.removesuffix(FEEDBACK), bytes(value.goal_id.uuid).hex(), value.feedback, now
            )


class Decoders:
    """Decodes messages. A topic that cannot be decoded is reported once, and left out."""

    def __init__(self, topics: dict[str, Topic]) -> None:
        self._topics = topics
        self._made: dict[str, Callable[[bytes], Any] | None] = {}
        self.problems: dict[str, str] = {}

    def decode(self, topic: str, data: bytes) -> Any:
        """Return the message; None if its type is unknown, or the bytes are not of that type."""
        try:
            if topic not in self._made:
                self._made[topic] = None
                self._made[topic] = decoder_of(self._topics[topic], self._topics.values())
            decode = self._made[topic]
            return None if decode is None else decode(data)
        except UNREADABLE as error:
            self.problems.setdefault(topic, f"'{topic}' is not shown: {peer_text(error, 300)}")
            return None
