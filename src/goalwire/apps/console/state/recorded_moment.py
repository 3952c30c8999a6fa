"""The state at a time of a bag: the robot, the log lines, and one chosen topic."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from goalwire.apps.console.state.recorded_follower import Follower
from goalwire.apps.console.state.recording import Decoders, Recording
from goalwire.apps.console.state.robot_model import RobotModel
from goalwire.apps.console.state.robot_state import RobotState
from goalwire.errors import BagError, peer_text
from goalwire.observe.log import LogBook, LogLine
from goalwire.records import record
from goalwire.rosbag2.reader import Reader
from goalwire.transforms.rigid import Rigid

_LOG = '/rosout'
_LINES = 200


@record
class Moment:
    """The content of the page at one time."""

    time: int
    """The moment, in ns since 1970."""
    model: RobotModel | None = None
    frame: str = ''
    """The frame in which the robot is shown."""
    base: Rigid | None = None
    links: tuple[tuple[str, list[float]], ...] = ()
    trail: tuple[tuple[float, float, float], ...] = ()
    silent_s: float | None = None
    """The age of the robot's last position, in s; None if it never reported one."""
    lines: tuple[LogLine, ...] = ()
    """The log lines, the latest first."""
    topic: str = ''
    message: Any = None
    """The latest message of the chosen topic."""
    message_time: int = 0
    problems: tuple[str, ...] = ()


class _Robot:
    """The recorded robot of one namespace."""

    def __init__(self, bag: Reader, decoders: Decoders, namespace: str) -> None:
        self.state = RobotState(namespace)
        joints, frames = f'{namespace}/joint_states', {f'{namespace}/tf', '/tf'}
        static = {f'{namespace}/tf_static', '/tf_static'}
        description = f'{namespace}/robot_description'
        self._joints, self._frames, self._static = joints, frames, static
        self._description = description
        self.follower = Follower(
            bag,
            decoders,
            {joints, description, *frames, *static},
            self._begin,
            self._take,
            latched=[description, *static],
        )

    def _begin(self) -> None:
        self.state = RobotState(self.state.namespace)

    def _take(self, topic: str, message: Any, time: int) -> None:
        state, at = self.state, time / 1e9
        if topic == self._description:
            state.take_description(message, at)
        elif topic == self._joints:
            state.take_joints(message, at)
        elif topic in self._static:
            state.take_static_frames(message, at)
        else:
            state.take_frames(message, at)


class _Latest:
    """The latest message of one topic."""

    def __init__(self, bag: Reader, decoders: Decoders, topic: str) -> None:
        self.message: Any = None
        self.time = 0
        self.follower = Follower(bag, decoders, [topic], self._begin, self._take)

    def _begin(self) -> None:
        self.message, self.time = None, 0

    def _take(self, _topic: str, message: Any, time: int) -> None:
        self.message, self.time = message, time


class _Log:
    """The log lines before a time."""

    def __init__(self, bag: Reader, decoders: Decoders) -> None:
        self.book = LogBook(_LINES)
        self.follower = Follower(bag, decoders, [_LOG], self._begin, self._take)

    def _begin(self) -> None:
        self.book = LogBook(_LINES)

    def _take(self, _topic: str, message: Any, _time: int) -> None:
        self.book.take(message)


class _Reading:
    """The opened bag of one page. Only for the thread that has made it."""

    def __init__(self, recording: Recording) -> None:
        self.bag = Reader(recording.path)
        self._decoders = Decoders(recording.topics)
        self._log = _Log(self.bag, self._decoders)
        self._robot: _Robot | None = None
        self._latest: _Latest | None = None

    def moment(self, time: int, robot: str | None, topic: str) -> Moment:
        """Return the state at a time; if the bag is broken there, the Moment has a problem and no robot."""
        try:
            return self._moment(time, robot, topic)
        except BagError as error:
            return Moment(time, topic=topic, problems=(peer_text(error, 300),))

    def _moment(self, time: int, name: str | None, topic: str) -> Moment:
        if name is not None and (self._robot is None or self._robot.state.namespace != name):
            self._robot = _Robot(self.bag, self._decoders, name)
        if topic and (self._latest is None or topic not in self._latest.follower.topics):
            self._latest = _Latest(self.bag, self._decoders, topic)
        robot, latest = self._robot, self._latest if topic else None
        for follower in (each.follower for each in (robot, latest, self._log) if each is not None):
            follower.move_to(time)
        state = RobotState('') if robot is None else robot.state
        frame, base = state.pose()
        moved = state.moved_at
        return Moment(
            time,
            state.model,
            frame,
            base,
            tuple(state.link_poses()),
            tuple(state.trail),
            None if moved is None else max(time / 1e9 - moved, 0.0),
            tuple(self._log.book.latest(_LINES)),
            topic,
            None if latest is None else latest.message,
            0 if latest is None else latest.time,
            (*self._decoders.problems.values(), *((state.problem,) if state.problem else ())),
        )


class Moments:
    """Reads moments on a thread of its own. If several are requested meanwhile, only the latest is read."""

    def __init__(self, recording: Recording, changed: Callable[[], object]) -> None:
        """`changed` is called when `latest` has changed."""
        self.latest: Moment | None = None
        self._recording = recording
        self._changed = changed
        self._pool = ThreadPoolExecutor(1, 'console-bag')
        self._reading: _Reading | None = None
        self._wanted: tuple[int, str | None, str] | None = None
        self._task: asyncio.Task[None] | None = None

    def want(self, time: int, robot: str | None, topic: str) -> None:
        """Request the state at a time, of the robot in a namespace and of a topic, if these are given."""
        self._wanted = time, robot, topic
        if self._task is None:
            self._task = asyncio.get_running_loop().create_task(self._read())

    async def _read(self) -> None:
        loop = asyncio.get_running_loop()
        try:
            while self._wanted is not None:
                wanted, self._wanted = self._wanted, None
                self.latest = await loop.run_in_executor(self._pool, self._at, *wanted)
                self._changed()
        finally:
            self._task = None

    def _at(self, time: int, robot: str | None, topic: str) -> Moment:
        if self._reading is None:
            self._reading = _Reading(self._recording)
        return self._reading.moment(time, robot, topic)

    def close(self) -> None:
        """Close the bag after the current reading."""
        self._wanted = None
        if self._task is not None:
            self._task.cancel()
        self._pool.submit(self._close)
        self._pool.shutdown(wait=False)

    def _close(self) -> None:
        if self._reading is not None:
            self._reading.bag.close()
