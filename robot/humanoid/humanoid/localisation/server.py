"""localiser: publishes the transform from `map` to `odom`, from scans matched with the map, as amcl does.

It subscribes to `map`, `odom`, `scan` and `initialpose`, and publishes `amcl_pose`, too.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from tf2_ros import TransformBroadcaster

from humanoid.clock import NANOSECONDS, seconds, time_msg
from humanoid.diagnostics import Diagnostics, Health
from humanoid.emergency.names import make_latched_qos
from humanoid.localisation.matcher import Match, Matcher
from humanoid.maps import Array, read
from humanoid.model import DESCRIPTION
from humanoid.nav2_states import tell_state
from humanoid.navigation.base import Pose2D, compose, invert
from humanoid.navigation.goal_check import FRAME
from humanoid.navigation.messages import place_frame, target_of
from humanoid.running import BadParameter, check_range, run
from humanoid.text import quote
from humanoid.world.file import load
from humanoid.world.names import BadWorld

MAP = 'map'
HOLDS_FOR = 0.3  # s: a transform is dated this far ahead, so that it is valid until the next one
REMEMBERED = 100  # number of odometry messages kept: those of 2 s
LOST_BELOW = 0.35  # share of points that fit: below it the robot counts as lost
LASER = DESCRIPTION.pose('laser', {}).translation


class Localiser(Node):
    """Corrects the drift of odometry with every scan."""

    def __init__(self) -> None:
        super().__init__('localiser')
        self._prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        world = self.declare_parameter('world', '').get_parameter_value().string_value
        self._matcher: Matcher | None = None
        self._odometry: deque[tuple[float, Pose2D]] = deque(maxlen=REMEMBERED)
        self._offset = self._first_pose(world)  # the pose of the frame odom on the map
        self._asked: Pose2D | None = None  # from initialpose: the next scan is matched around this pose
        self._match: Match | None = None
        self._transforms = TransformBroadcaster(self)
        self._pose = self.create_publisher(PoseWithCovarianceStamped, 'amcl_pose', make_latched_qos())
        self.create_subscription(OccupancyGrid, 'map', self._take_map, make_latched_qos())
        self.create_subscription(Odometry, 'odom', self._hear_odometry, 50)
        self.create_subscription(LaserScan, 'scan', self._hear_scan, qos_profile_sensor_data)
        self.create_subscription(PoseWithCovarianceStamped, 'initialpose', self._place_robot, 1)
        self.create_service(GetState, 'amcl/get_state', self._tell_state)
        Diagnostics(self, 'localisation', self._health)
        self.get_logger().info('Localiser ready')

    def _first_pose(self, world: str) -> Pose2D:
        """Return the robot's start pose: of the parameter initial_pose, else of the world file."""
        try:
            start = load(world).start if world else (0.0, 0.0, 0.0)
        except BadWorld as error:
            raise BadParameter(str(error)) from None
        pose = self.declare_parameter('initial_pose', list(start)).get_parameter_value().double_array_value
        if len(pose) != 3:
            raise BadParameter(f'the parameter initial_pose has {len(pose)} numbers, not 3: x, y and yaw')
        for number in pose:
            check_range('initial_pose', number, -1000.0, 1000.0)
        return Pose2D(*pose)

    def _take_map(self, grid: OccupancyGrid) -> None:
        try:
            self._matcher = Matcher(*read(grid))
        except ValueError as error:
            self.get_logger().error(f'the map is not taken: {error}')

    def _hear_odometry(self, told: Odometry) -> None:
        self._odometry.append((seconds(told.header.stamp), target_of(told.pose.pose)))

    def _place_robot(self, told: PoseWithCovarianceStamped) -> None:
        """Take a pose that a person has set: the next scan is matched around it."""
        pose, frame = target_of(told.pose.pose), told.header.frame_id
        if frame not in ('', MAP):
            self.get_logger().warning(f'Ignored initialpose: it is in {quote(frame)}, not in {MAP!r}')
        elif not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
            self.get_logger().warning('Ignored initialpose: a number of it is not finite')
        else:
            self._asked = pose

    def _hear_scan(self, scan: LaserScan) -> None:
        if self._matcher is None or not self._odometry:
            return
        taken = seconds(scan.header.stamp)
        _, counted = min(self._odometry, key=lambda each: abs(each[0] - taken))
        points = scan_points(scan)
        if self._asked is not None:
            match, self._asked = self._matcher.search(points, self._asked), None
            where = f'({match.pose.x:.2f}, {match.pose.y:.2f}) m'
            self.get_logger().info(f'Placed at {where}, where {match.fits:.0%} of the scan fits')
        else:
            match = self._matcher.refine(points, compose(self._offset, counted))
        self._match = match
        self._offset = compose(match.pose, invert(counted))
        self._publish(scan, match)

    def _publish(self, scan: LaserScan, match: Match) -> None:
        holds_until = time_msg(round((seconds(scan.header.stamp) + HOLDS_FOR) * NANOSECONDS))
        self._transforms.sendTransform(place_frame(MAP, self._offset, holds_until, f'{self._prefix}{FRAME}'))
        message = PoseWithCovarianceStamped()
        message.header.frame_id, message.header.stamp = MAP, scan.header.stamp
        pose = message.pose.pose
        pose.position.x, pose.position.y = match.pose.x, match.pose.y
        pose.orientation.z = math.sin(match.pose.yaw / 2.0)
        pose.orientation.w = math.cos(match.pose.yaw / 2.0)
        covariance = np.zeros((6, 6))
        covariance[np.ix_([0, 1, 5], [0, 1, 5])] = match.covariance
        message.pose.covariance = covariance.reshape(-1)
        self._pose.publish(message)

    def _tell_state(self, _request: GetState.Request, response: GetState.Response) -> GetState.Response:
        """Answer "active" once a scan was matched: clients of Nav2 wait for amcl's state."""
        return tell_state(response, is_active=self._match is not None)

    def _health(self) -> Health:
        if self._match is None:
            return Health('waits for map, odom and scan', DiagnosticStatus.WARN)
        values = {'fits': f'{self._match.fits:.2f}'}
        if self._match.fits < LOST_BELOW:
            advice = 'the scan does not fit the map: tell where the robot is on initialpose'
            return Health(advice, DiagnosticStatus.WARN, values)
        return Health('knows where it is', values=values)


def scan_points(scan: LaserScan) -> Array:
    """Return the points where the beams of a scan ended, in the frame base_link: (n, 2), in m."""
    ranges = np.asarray(scan.ranges, dtype=np.float64)
    angles = scan.angle_min + np.arange(len(ranges)) * scan.angle_increment
    met = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges <= scan.range_max)
    x = LASER[0] + ranges[met] * np.cos(angles[met])
    y = LASER[1] + ranges[met] * np.sin(angles[met])
    return np.stack([x, y], axis=1)


def main(args: Sequence[str] | None = None) -> int:
    return run(Localiser, args)


if __name__ == '__main__':
    raise SystemExit(main())
