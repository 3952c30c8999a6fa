"""Goals of the navigator: their frames, and the checks that refuse them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.time import Time
from tf2_ros import Buffer, TransformException

from humanoid.clock import seconds
from humanoid.maps import Array
from humanoid.model import BASE
from humanoid.navigation.base import Pose2D, compose, yaw_of
from humanoid.navigation.goal_check import FRAME, LONGEST, refusal
from humanoid.navigation.messages import BASE_LINK, target_of
from humanoid.route.costmap import KEEPS, Costmap
from humanoid.route.planner import OFF_BY, NoWay, length, plan, points_of, space
from humanoid.text import quote

MAP = 'map'
MOST_POSES = 100
MOST_POINTS, LONGEST_PATH = 10_000, 500.0  # poses, m: of a path that is given
WITHIN_REACH = 1.5  # m between the robot and the path that it shall follow, at most
LATEST = 1.0  # s


class Refused(Exception):
    """The goal is refused; the text says why."""


class Frames:
    """Transforms poses from any frame that TF knows."""

    def __init__(self, buffer: Buffer, prefix: str) -> None:
        self._buffer, self._prefix = buffer, prefix

    def place(self, frame: str) -> Pose2D | None:
        """Return the map pose of the frame named `frame`, or else prefix + `frame`; None if TF lacks both."""
        for name in dict.fromkeys((frame, f'{self._prefix}{frame}')):
            try:
                found = self._buffer.lookup_transform(MAP, name, Time()).transform
            except TransformException:
                continue
            turn, at = found.rotation, found.translation
            return Pose2D(at.x, at.y, yaw_of(turn.x, turn.y, turn.z, turn.w))
        return None

    def robot(self, now: float) -> Pose2D | None:
        """Return the robot's pose on the map; None if TF has no pose from the last LATEST s. `now` in s."""
        try:
            found = self._buffer.lookup_transform(MAP, f'{self._prefix}{BASE_LINK}', Time())
        except TransformException:
            return None
        if abs(now - seconds(found.header.stamp)) > LATEST:
            return None
        turn, at = found.transform.rotation, found.transform.translation
        return Pose2D(at.x, at.y, yaw_of(turn.x, turn.y, turn.z, turn.w))

    def on_map(self, goal: PoseStamped, default: str = MAP) -> Pose2D:
        """Return a goal's pose on the map; a goal without a frame is in `default`. Raises Refused."""
        return self.all_on_map([goal], default)[0]

    def all_on_map(self, goals: Sequence[PoseStamped], default: str = MAP) -> list[Pose2D]:
        """Return the poses of goals on the map; each frame is looked up once. Raises Refused."""
        places: dict[str, Pose2D] = {}
        found = []
        for goal in goals:
            frame, at, turn = goal.header.frame_id or default, goal.pose.position, goal.pose.orientation
            problem = refusal(FRAME, (at.x, at.y, at.z), (turn.x, turn.y, turn.z, turn.w), LONGEST)
            if problem is not None:
                raise Refused(problem)
            if frame not in places:
                places[frame] = self.find(frame)
            found.append(compose(places[frame], target_of(goal.pose)))
        return found

    def find(self, frame: str) -> Pose2D:
        """Return the pose of a frame on the map. Raises Refused if TF does not have it."""
        place = self.place(frame)
        if place is None:
            raise Refused(f'frame_id {quote(frame)} is unknown to TF, or not connected with {MAP!r}')
        return place


def check(costmap: Costmap | None, pose: Pose2D | None, targets: Sequence[Pose2D]) -> None:
    """Raise Refused unless the map has a free path from `pose` through all targets.

    Obstacles that are not on the map do not count: they may have gone before the robot arrives.
    """
    costmap, pose = check_place(costmap, pose)
    if not 0 < len(targets) <= MOST_POSES:
        raise Refused(f'{len(targets)} poses are not from 1 to {MOST_POSES}')
    for target in targets:
        where = f'({target.x:.2f}, {target.y:.2f}) m'
        point = np.array([[target.x, target.y]])
        if not costmap.geometry.inside(costmap.geometry.cells(point))[0]:
            raise Refused(f'the goal {where} is off the map')
        room = float(costmap.measure_mapped(point)[0])
        if room < KEEPS:
            raise Refused(
                f'the goal {where} is {room:.2f} m from a thing of the map; {KEEPS:g} m is the least'
            )
    for start, target in zip((pose, *targets), targets, strict=False):
        try:
            plan(costmap.geometry, costmap.mapped, start, target)
        except NoWay as problem:
            raise Refused(f'({target.x:.2f}, {target.y:.2f}) m: {problem}') from None


def poses_of(path: Path) -> Sequence[PoseStamped]:
    """Return the path's poses; those of a path with a frame are all in that frame, as in Nav2."""
    if not path.header.frame_id:
        return list(path.poses)
    return [PoseStamped(header=path.header, pose=each.pose) for each in path.poses]


def check_id(field: str, asked: str, only: str) -> None:
    """Raise Refused unless a goal's field is empty or names the only one there is."""
    if asked not in ('', only):
        raise Refused(f'{field} {quote(asked)} is not there; leave it empty or write {only!r}')


def check_map(costmap: Costmap | None) -> Costmap:
    """Return the map. Raises Refused if there is none."""
    if costmap is None:
        raise Refused('there is no map yet: nothing has come on map')
    return costmap


def check_place(costmap: Costmap | None, pose: Pose2D | None) -> tuple[Costmap, Pose2D]:
    """Return the map and the robot's pose. Raises Refused if one of them is unknown."""
    costmap = check_map(costmap)
    if pose is None:
        raise Refused('the robot does not know where it is: no transform from map to base_link')
    return costmap, pose


def check_path(costmap: Costmap | None, pose: Pose2D | None, poses: Sequence[Pose2D]) -> None:
    """Raise Refused unless the robot can follow the path from where it is, past the things of the map."""
    costmap, pose = check_place(costmap, pose)
    check_length(poses)
    line = space(points_of(poses))
    away = np.hypot(line[:, 0] - pose.x, line[:, 1] - pose.y)
    if away.min() > WITHIN_REACH:
        raise Refused(f'the robot is {away.min():.2f} m from the path; {WITHIN_REACH:g} m is the most')
    near = (costmap.measure_mapped(line) < BASE.radius) & (away > OFF_BY)
    if near.any():
        x, y = line[int(near.argmax())]
        raise Refused(f'the path leads through a thing of the map, or off the map, near ({x:.1f}, {y:.1f}) m')


def check_length(poses: Sequence[Pose2D]) -> None:
    """Raise Refused unless the path has poses, and is not too long."""
    if not poses:
        raise Refused('the path is empty')
    if len(poses) > MOST_POINTS:
        raise Refused(f'the path has {len(poses)} poses; {MOST_POINTS} are the most')
    way = length(points_of(poses))
    if way > LONGEST_PATH:
        raise Refused(f'the path is {way:.0f} m long; {LONGEST_PATH:g} m is the most')


def plan_path(costmap: Costmap | None, start: Pose2D | None, target: Pose2D) -> Array:
    """Plan a path between two poses that avoids all obstacles seen now. Raises Refused and NoWay."""
    costmap, start = check_place(costmap, start)
    return plan(costmap.geometry, costmap.clearance, start, target)


def judge_by(check_all: Callable[[], None]) -> Callable[[], str | None]:
    """Return a check for `endings.judge`: it returns the text of a Refused from `check_all`, or None."""

    def judge() -> str | None:
        try:
            check_all()
        except Refused as refused:
            return str(refused)
        return None

    return judge
