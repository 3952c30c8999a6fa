"""world_server: simulates the world around the robot, its doors and people, and the robot's scanner.

It replaces real walls and a real scanner; a real robot runs without it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan, PointCloud2
from std_msgs.msg import Float64
from std_srvs.srv import SetBool
from tf2_ros import StaticTransformBroadcaster
from visualization_msgs.msg import MarkerArray

from humanoid.clock import now, stamp
from humanoid.emergency.names import make_latched_qos
from humanoid.model import DESCRIPTION
from humanoid.navigation.base import Pose2D, compose
from humanoid.navigation.messages import place_frame, target_of
from humanoid.navigation.truth import TRUTH
from humanoid.running import BadParameter, check_range, run
from humanoid.urdf import Transform
from humanoid.world import camera
from humanoid.world.file import load
from humanoid.world.messages import FRAME as MAP
from humanoid.world.messages import laser_scan, marker_array, occupancy
from humanoid.world.names import BadWorld
from humanoid.world.scene import Scene

STEP = 0.05  # s between two steps of the simulated world: 20 Hz
MARKERS_EVERY = 4  # steps between two marker messages: 5 Hz while a person walks
SCAN_EVERY = 2  # steps between two scans: 10 Hz
LOOK_EVERY = 4  # steps between two images: 5 Hz
HEAD = ('waist', 'head_pan', 'head_tilt')  # the joints that turn the camera
LASER = DESCRIPTION.pose('laser', {}).translation


class WorldServer(Node):
    """Publishes the world, and scans of it from the robot's true pose, which `ground_truth` has."""

    def __init__(self) -> None:
        super().__init__('world_server')
        world = self.declare_parameter('world', 'house').get_parameter_value().string_value
        self._prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        resolution = self._number('map_resolution', 0.05, 0.01, 1.0)
        self._noise = self._number('scan_noise', 0.01, 0.0, 1.0)
        seed = self.declare_parameter('seed', 0).get_parameter_value().integer_value
        try:
            self._scene = Scene(load(world))
        except BadWorld as error:
            raise BadParameter(str(error)) from None
        self._chance = np.random.default_rng(abs(seed))
        self._truth: Odometry | None = None
        self._stepped, self._steps = now(self), 0
        self._markers = self.create_publisher(MarkerArray, 'world_markers', make_latched_qos())
        self._map = self.create_publisher(OccupancyGrid, 'map', make_latched_qos())
        self._scan = self.create_publisher(LaserScan, 'scan', qos_profile_sensor_data)
        self._clearance = self.create_publisher(Float64, 'clearance', 10)
        self._camera_noise = self._number('camera_noise', 0.002, 0.0, 1.0)
        self._joints: dict[str, float] = {}
        self._depth = self.create_publisher(Image, 'camera/depth/image_raw', qos_profile_sensor_data)
        self._depth_info = self.create_publisher(
            CameraInfo, 'camera/depth/camera_info', qos_profile_sensor_data
        )
        self._points = self.create_publisher(PointCloud2, 'camera/depth/points', qos_profile_sensor_data)
        self.create_subscription(JointState, 'joint_states', self._hear_joints, qos_profile_sensor_data)
        self.create_subscription(Odometry, TRUTH, self._hear, qos_profile_sensor_data)
        for door in self._scene.file.doors:
            self.create_service(SetBool, f'doors/{door.name}', partial(self._move_door, door.name))
        self._map.publish(occupancy(self._scene.file.solids, resolution, stamp(self)))
        self._home = StaticTransformBroadcaster(self)
        self._home.sendTransform(place_frame(MAP, Pose2D(*self._scene.file.start), stamp(self), 'home'))
        self._show()
        self.create_timer(STEP, self._step)
        self.get_logger().info(
            f'World Server ready: {self._scene.file.name}, {len(self._scene.file.solids)} things at rest, '
            f'{len(self._scene.file.doors)} doors, {len(self._scene.walkers)} people'
        )

    def _number(self, name: str, default: float, lowest: float, greatest: float) -> float:
        value = self.declare_parameter(name, default).get_parameter_value().double_value
        check_range(name, value, lowest, greatest)
        return value

    @property
    def _robot(self) -> Pose2D | None:
        """The robot's true pose in the world, if known; `ground_truth` is relative to the robot's start."""
        if self._truth is None:
            return None
        return compose(Pose2D(*self._scene.file.start), target_of(self._truth.pose.pose))

    def _hear(self, truth: Odometry) -> None:
        self._truth = truth

    def _hear_joints(self, state: JointState) -> None:
        self._joints = {
            name: at for name, at in zip(state.name, state.position, strict=False) if name in HEAD
        }

    def _move_door(self, name: str, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        """Open a door (true) or close it (false); a door does not close on a person or the robot."""
        if not request.data and not self._scene.can_close(name, self._robot):
            response.message = f'the door {name} stays open: somebody stands in it'
            return response
        self._scene.open[name] = request.data
        response.success = True
        response.message = f'the door {name} is {"open" if request.data else "closed"}'
        self.get_logger().info(response.message)
        self._show()
        return response

    def _show(self) -> None:
        scene = self._scene
        self._markers.publish(marker_array([*scene.file.solids, *scene.moving], stamp(self)))

    def _step(self) -> None:
        moment = now(self)
        elapsed, self._stepped = max(moment - self._stepped, 0.0), moment
        self._steps += 1
        robot = self._robot
        self._scene.step(min(elapsed, 1.0), robot)
        if self._steps % MARKERS_EVERY == 0 and any(walker.walks for walker in self._scene.walkers):
            self._show()
        if self._truth is not None and robot is not None and self._steps % SCAN_EVERY == 0:
            self._sense(self._truth, robot)
            if self._steps % LOOK_EVERY == 0:
                self._look(self._truth, robot)

    def _sense(self, truth: Odometry, robot: Pose2D) -> None:
        """Publish a scan from the robot's pose, as by an upright scanner: the robot's tilt is ignored."""
        laser = compose(robot, Pose2D(LASER[0], LASER[1]))
        height = truth.pose.pose.position.z + LASER[2]
        ranges = self._scene.scan(laser, height, self._noise, self._chance)
        self._scan.publish(laser_scan(ranges, f'{self._prefix}laser', truth.header.stamp, STEP * SCAN_EVERY))
        self._clearance.publish(Float64(data=self._scene.clearance(robot)))

    def _look(self, truth: Odometry, robot: Pose2D) -> None:
        """Publish the camera's images, if there are subscribers."""
        outputs = (self._depth, self._depth_info, self._points)
        if not any(output.get_subscription_count() for output in outputs):
            return
        turn = truth.pose.pose.orientation
        half = (robot.yaw - target_of(truth.pose.pose).yaw) / 2.0
        start = Transform(rotation=(0.0, 0.0, math.sin(half), math.cos(half)))
        tilted = start @ Transform(rotation=(turn.x, turn.y, turn.z, turn.w))
        pelvis = Transform((robot.x, robot.y, truth.pose.pose.position.z), tilted.rotation)
        eye = pelvis @ DESCRIPTION.pose(camera.FRAME, self._joints)
        depths = camera.look(self._scene, eye, self._camera_noise, self._chance)
        frame, when = f'{self._prefix}{camera.FRAME}', truth.header.stamp
        self._depth.publish(camera.image(depths, frame, when))
        self._depth_info.publish(camera.camera_info(frame, when))
        self._points.publish(camera.points(depths, frame, when))


def main(args: Sequence[str] | None = None) -> int:
    make: Callable[[], Node] = WorldServer
    return run(make, args)


if __name__ == '__main__':
    raise SystemExit(main())
