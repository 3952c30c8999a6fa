"""The actions that answer with a path and move nothing: `compute_path_to_pose` and `smooth_path` of Nav2."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from nav2_msgs.action import ComputePathToPose, SmoothPath
from nav_msgs.msg import Path
from rclpy.action import ActionServer, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from humanoid.clock import duration_msg, now, seconds, stamp
from humanoid.maps import Array
from humanoid.model import BASE
from humanoid.navigation.base import Pose2D
from humanoid.navigation.messages import target_of
from humanoid.route.costmap import Costmap
from humanoid.route.goals import MAP, Frames, Refused, check_id, check_length, check_map, plan_path, poses_of
from humanoid.route.messages import path_message
from humanoid.route.planner import NoWay, points_of
from humanoid.route.smoother import find_collision, smooth

SMOOTHER = 'simple_smoother'  # the name that Nav2's own configuration has for its smoother


class PathServers:
    """The two action servers. They accept every goal, and abort those without a path with Nav2's code."""

    def __init__(
        self,
        node: Node,
        frames: Frames,
        get_costmap: Callable[[], Costmap | None],
        show: Callable[[Path], None],
    ) -> None:
        """`show` is called with each planned path; smooth ones are published on `plan_smoothed`."""
        self._node, self._frames, self._get_costmap, self._show = node, frames, get_costmap, show
        self._smooth_plan = node.create_publisher(Path, 'plan_smoothed', 1)
        self.servers = [
            ActionServer(
                node,
                type_,
                name,
                execute_callback=execute,
                goal_callback=lambda _goal: GoalResponse.ACCEPT,
            )
            for type_, name, execute in (
                (ComputePathToPose, 'compute_path_to_pose', self._compute),
                (SmoothPath, 'smooth_path', self._smooth),
            )
        ]

    def _compute(self, goal_handle: ServerGoalHandle) -> ComputePathToPose.Result:
        """Serve ComputePathToPose: plan a path without driving along it."""
        request, result = goal_handle.request, ComputePathToPose.Result()
        began = now(self._node)
        try:
            target = self._frames.on_map(request.goal)
            start = self._frames.on_map(request.start) if request.use_start else self._frames.robot(began)
            path = plan_path(self._get_costmap(), start, target)
        except (Refused, NoWay) as problem:
            is_frame = isinstance(problem, Refused)
            result.error_code = result.TF_ERROR if is_frame else result.NO_VALID_PATH
            result.error_msg = str(problem)
            goal_handle.abort()
            return result
        result.path = path_message(path, target, MAP, stamp(self._node))
        result.planning_time = duration_msg(now(self._node) - began)
        self._show(result.path)
        goal_handle.succeed()
        return result

    def _smooth(self, goal_handle: ServerGoalHandle) -> SmoothPath.Result:
        """Serve SmoothPath: the smooth path has the frame of the given one, and its first and last pose."""
        result = SmoothPath.Result()
        try:
            self._fill(goal_handle.request, result)
        except PathProblem as problem:
            result.error_code, result.error_msg = problem.code, str(problem)
            self._node.get_logger().warning(f'smooth_path: {problem}')
            goal_handle.abort()
            return result
        goal_handle.succeed()
        return result

    def _fill(self, request: SmoothPath.Goal, result: SmoothPath.Result) -> None:
        """Fill the result with the smooth path. Raises PathProblem."""
        began, codes = time.monotonic(), SmoothPath.Result
        with _refused_as(codes.INVALID_SMOOTHER):
            check_id('smoother_id', request.smoother_id, SMOOTHER)
        with _refused_as(codes.UNKNOWN):
            costmap = check_map(self._get_costmap())
        with _refused_as(codes.INVALID_PATH):
            poses, origin = self._read(request.path)
        allowed = seconds(request.max_smoothing_duration)
        smoothed = smooth(costmap, points_of(poses), lambda: time.monotonic() - began >= allowed)
        result.path = _replace(request.path, _seen_from(origin, smoothed.points))
        result.was_completed = smoothed.is_complete
        result.smoothing_duration = duration_msg(time.monotonic() - began)
        self._smooth_plan.publish(result.path)
        if request.check_for_collisions and (at := find_collision(costmap, smoothed.points, BASE.radius)):
            where = f'({at[0]:.1f}, {at[1]:.1f}) m on the map'
            why = f'the path comes nearer than {BASE.radius:g} m to something, near {where}'
            raise PathProblem(codes.SMOOTHED_PATH_IN_COLLISION, why)

    def _read(self, path: Path) -> tuple[list[Pose2D], Pose2D]:
        """Return a path's poses on the map, and the pose of its frame there. Raises Refused."""
        poses = self._frames.all_on_map(poses_of(path))
        check_length(poses)
        return poses, self._frames.find(_frame_of(path))


class PathProblem(Exception):
    """A path cannot be made smooth; the text says why."""

    def __init__(self, code: int, why: str) -> None:
        super().__init__(why)
        self.code = code


@contextmanager
def _refused_as(code: int) -> Iterator[None]:
    """Turn a Refused of the block into a PathProblem with this code."""
    try:
        yield
    except Refused as problem:
        raise PathProblem(code, str(problem)) from None


def _frame_of(path: Path) -> str:
    return path.header.frame_id or path.poses[0].header.frame_id or MAP


def _seen_from(frame: Pose2D, points: Array) -> Array:
    """Return points (n, 2) of the map as coordinates in `frame`, whose pose on the map is given."""
    cos, sin = math.cos(frame.yaw), math.sin(frame.yaw)
    turned: Array = (points - [frame.x, frame.y]) @ np.array([[cos, -sin], [sin, cos]])
    return turned


def _replace(path: Path, points: Array) -> Path:
    """Return the path through other points (n, 2), in its own frame; its first and last pose stay."""
    first, last = path.poses[0].pose, path.poses[-1].pose
    made = path_message(points, target_of(last), _frame_of(path), path.header.stamp)
    made.poses[0].pose, made.poses[-1].pose = first, last
    return made
