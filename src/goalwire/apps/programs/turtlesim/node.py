"""turtlesim_node: turtles that are moved by topics, services and an action."""

from __future__ import annotations

import math
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from geometry_msgs.msg import Twist
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.exceptions import NameValidationException
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Empty
from turtlesim.action import RotateAbsolute
from turtlesim.msg import Color, Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from goalwire.apps.programs.running import spin
from goalwire.apps.programs.turtlesim.canvas import Colour
from goalwire.apps.programs.turtlesim.world import BACKGROUND, STEP_S, Line, Turtle, World, normalize
from goalwire.apps.programs.window import Window, run_in_window, to_data_url

DEPTH = 7
TURN_RAD_S = 1.0
CLOSE_RAD = 0.02
"""The distance from the goal at which a rotation ends, in rad."""
STEPS_A_PICTURE = 2
"""Browsers get every second step: 31 pictures a second."""


class TurtleSim(Node):
    """The simulator: parameters `background_r`, `_g`, `_b` (0 to 255) and `holonomic`.

    Services `clear`, `reset`, `spawn`, `kill`; each turtle has its own topics, services and action.
    """

    def __init__(self, window: Window) -> None:
        super().__init__('turtlesim')
        for name, value in zip('rgb', BACKGROUND, strict=True):
            descriptor = ParameterDescriptor(
                description=f'{name} of the background',
                integer_range=[IntegerRange(from_value=0, to_value=255, step=1)],
            )
            self.declare_parameter(f'background_{name}', value, descriptor)
        self._holonomic = self.declare_parameter('holonomic', value=False)
        self._window = window
        self.lock = window.lock
        self._lines: list[Line] = []
        self._steps = 0
        self._sent: list[tuple[Any, ...]] = []
        self._endpoints: dict[str, TurtleEndpoints] = {}
        with self.lock:
            self.world = World(self._lines.append, self._warn_of_wall)
            window.describe = self._describe
        self.create_service(Empty, 'clear', self._clear)
        self.create_service(Empty, 'reset', self._reset)
        self.create_service(Spawn, 'spawn', self._spawn)
        self.create_service(Kill, 'kill', self._kill)
        self.get_logger().info(f'Starting turtlesim with node name {self.get_fully_qualified_name()}')
        self._begin()
        self.create_timer(STEP_S, self._step)

    @property
    def is_holonomic(self) -> bool:
        """True if turtles may move sideways."""
        return bool(self._holonomic.value)

    def now_s(self) -> float:
        """Return the node's time in seconds."""
        return self.get_clock().now().nanoseconds / 1e9

    def _background(self) -> Colour:
        red, green, blue = (
            self.get_parameter(f'background_{name}').get_parameter_value().integer_value for name in 'rgb'
        )
        return red, green, blue

    def _begin(self) -> None:
        with self.lock:
            turtle = self.world.spawn_first()
            self._repaint()
        self._attach(turtle)

    def _attach(self, turtle: Turtle) -> None:
        self.get_logger().info(
            f'Spawning turtle [{turtle.name}] at x=[{turtle.x:f}], y=[{turtle.y:f}], theta=[{turtle.theta:f}]'
        )
        self._endpoints[turtle.name] = TurtleEndpoints(self, turtle)

    def _repaint(self) -> None:
        """Paint the background over everything; the lock is held."""
        self.world.canvas.fill(self._background())
        self._lines.clear()
        self._window.send(self._describe())

    def _describe(self) -> dict[str, Any]:
        return {'image': to_data_url(self.world.canvas.to_png()), 'turtles': self._turtles()}

    def _turtles(self) -> list[tuple[Any, ...]]:
        return [(each.name, each.x, each.y, each.theta, each.look) for each in self.world.turtles.values()]

    def _step(self) -> None:
        now = self.now_s()
        with self.lock:
            for endpoints in self._endpoints.values():
                endpoints.rotate(now)
                self.world.step(endpoints.turtle, now)
        for endpoints in list(self._endpoints.values()):
            endpoints.publish(self.world.canvas.colour_at(*endpoints.turtle.pixel()))
        self._steps += 1
        if self._steps % STEPS_A_PICTURE == 0:
            self._send()

    def _send(self) -> None:
        turtles = self._turtles()
        if turtles == self._sent and not self._lines:
            return
        lines = [
            (*line.start, *line.end, '#{:02x}{:02x}{:02x}'.format(*line.colour), line.width)
            for line in self._lines
        ]
        self._lines.clear()
        self._sent = turtles
        with self.lock:
            self._window.send({'turtles': turtles, 'lines': lines})

    def _warn_of_wall(self, _name: str, x: float, y: float) -> None:
        self.get_logger().warning(f'Oh no! I hit the wall! (Clamping from [x={x:f}, y={y:f}])')

    def _clear(self, _request: Empty.Request, response: Empty.Response) -> Empty.Response:
        self.get_logger().info('Clearing turtlesim.')
        with self.lock:
            self._repaint()
        return response

    def _reset(self, _request: Empty.Request, response: Empty.Response) -> Empty.Response:
        self.get_logger().info('Resetting turtlesim.')
        for endpoints in self._endpoints.values():
            endpoints.close()
        self._endpoints.clear()
        self._begin()
        return response

    def _spawn(self, request: Spawn.Request, response: Spawn.Response) -> Spawn.Response:
        if not all(map(math.isfinite, (request.x, request.y, request.theta))):
            self.get_logger().error('A turtle needs finite numbers for its place and heading')
            return response
        with self.lock:
            turtle = self.world.spawn(request.name, request.x, request.y, request.theta)
        if turtle is None:
            self.get_logger().error(f'A turtle named [{request.name}] already exists')
            return response
        try:
            self._attach(turtle)
        except NameValidationException:  # no topic can have the turtle's name
            with self.lock:
                del self.world.turtles[turtle.name]
            self.get_logger().error(f'A turtle cannot be named [{request.name}]: topics have its name')
            return response
        response.name = turtle.name
        return response

    def _kill(self, request: Kill.Request, response: Kill.Response) -> Kill.Response:
        endpoints = self._endpoints.pop(request.name, None)
        if endpoints is None:
            self.get_logger().error(f'Tried to kill turtle [{request.name}], which does not exist')
            return response
        endpoints.close()
        with self.lock:
            del self.world.turtles[request.name]
        return response


class TurtleEndpoints:
    """One turtle's topics `cmd_vel`, `pose`, `color_sensor`, its three services, and its action."""

    def __init__(self, node: TurtleSim, turtle: Turtle) -> None:
        """Raises NameValidationException for a name that topics cannot have."""
        self.turtle = turtle
        self._node = node
        self._rotation: Rotation | None = None
        name = turtle.name
        self._pose = node.create_publisher(Pose, f'{name}/pose', DEPTH)
        self._colour = node.create_publisher(Color, f'{name}/color_sensor', DEPTH)
        self._commands = node.create_subscription(Twist, f'{name}/cmd_vel', self._command, DEPTH)
        self._services = (
            node.create_service(SetPen, f'{name}/set_pen', self._set_pen),
            node.create_service(TeleportRelative, f'{name}/teleport_relative', self._teleport_by),
            node.create_service(TeleportAbsolute, f'{name}/teleport_absolute', self._teleport),
        )
        self._action = ActionServer(
            node,
            RotateAbsolute,
            f'{name}/rotate_absolute',
            self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def close(self) -> None:
        """Remove all endpoints of the turtle from the graph."""
        self._end_rotation(succeeded=False)
        self._action.destroy()
        for service in self._services:
            self._node.destroy_service(service)
        self._node.destroy_subscription(self._commands)
        self._node.destroy_publisher(self._pose)
        self._node.destroy_publisher(self._colour)

    def publish(self, colour: Colour) -> None:
        """Publish the turtle's pose, and the colour below the turtle."""
        turtle = self.turtle
        self._pose.publish(
            Pose(
                x=turtle.x,
                y=turtle.y,
                theta=turtle.theta,
                linear_velocity=turtle.forward,
                angular_velocity=turtle.turn,
            )
        )
        red, green, blue = colour
        self._colour.publish(Color(r=red, g=green, b=blue))

    def rotate(self, now_s: float) -> None:
        """Turn towards the goal of the action for one more step, or end it."""
        rotation = self._rotation
        if rotation is None:
            return
        if rotation.goal_handle.is_cancel_requested:
            self._node.get_logger().info('Canceling rotation goal')
            self._end_rotation(succeeded=False)
            return
        remaining = normalize(rotation.goal_handle.request.theta - self.turtle.theta)
        if abs(remaining) < CLOSE_RAD:
            self._node.get_logger().info('Rotation goal completed successfully')
            self._end_rotation(succeeded=True)
            return
        self.turtle.command(now_s, 0.0, 0.0, math.copysign(TURN_RAD_S, remaining))
        rotation.goal_handle.publish_feedback(RotateAbsolute.Feedback(remaining=remaining))

    def _end_rotation(self, *, succeeded: bool) -> None:
        rotation, self._rotation = self._rotation, None
        if rotation is not None:
            self.turtle.command(-math.inf, 0.0, 0.0, 0.0)
            rotation.ended.set_result(succeeded)

    async def _execute(self, goal_handle: ServerGoalHandle) -> RotateAbsolute.Result:
        if not math.isfinite(goal_handle.request.theta):
            self._node.get_logger().error('A rotation needs a finite number as its heading')
            goal_handle.abort()
            return RotateAbsolute.Result()
        if self._rotation is not None:
            self._node.get_logger().warning(
                'Rotation goal received before a previous goal finished. Aborting previous goal'
            )
            self._end_rotation(succeeded=False)
        before = self.turtle.theta
        rotation = self._rotation = Rotation(goal_handle)
        succeeded = await rotation.ended
        if succeeded:
            goal_handle.succeed()
        elif goal_handle.is_cancel_requested:
            goal_handle.canceled()
        else:
            goal_handle.abort()
        return RotateAbsolute.Result(delta=normalize(before - self.turtle.theta))

    def _command(self, twist: Twist) -> None:
        sideways = twist.linear.y if self._node.is_holonomic else 0.0
        speeds = (twist.linear.x, sideways, twist.angular.z)
        if not all(map(math.isfinite, speeds)):
            self._node.get_logger().warning('The turtle stops: the speeds of a command are not finite')
            speeds = (0.0, 0.0, 0.0)
        self.turtle.command(self._node.now_s(), *speeds)

    def _set_pen(self, request: SetPen.Request, response: SetPen.Response) -> SetPen.Response:
        if request.off:
            self.turtle.pen = None
        else:
            self.turtle.pen = (request.r, request.g, request.b)
            self.turtle.width = request.width or 1
        return response

    def _teleport(
        self, request: TeleportAbsolute.Request, response: TeleportAbsolute.Response
    ) -> TeleportAbsolute.Response:
        if self._are_numbers(request.x, request.y, request.theta):
            with self._node.lock:
                self._node.world.teleport(self.turtle, request.x, request.y, request.theta)
        return response

    def _teleport_by(
        self, request: TeleportRelative.Request, response: TeleportRelative.Response
    ) -> TeleportRelative.Response:
        if self._are_numbers(request.linear, request.angular):
            with self._node.lock:
                self._node.world.teleport_by(self.turtle, request.linear, request.angular)
        return response

    def _are_numbers(self, *values: float) -> bool:
        if all(map(math.isfinite, values)):
            return True
        self._node.get_logger().error('A turtle cannot be moved: the target is not a finite number')
        return False


class Rotation:
    """A goal in execution; the future `ended` gives True if the goal was reached."""

    def __init__(self, goal_handle: ServerGoalHandle) -> None:
        self.goal_handle = goal_handle
        self.ended: Future[bool] = Future()


def main(argv: Sequence[str] | None = None) -> int:
    """Show the turtles until Ctrl-C; returns the exit code."""
    arguments = list(sys.argv if argv is None else argv)
    parser = ArgumentParser('turtlesim_node', description='Turtles in a page of your browser.')
    page = files(__package__).joinpath('page.html').read_bytes()

    def run(window: Window, _words: Namespace) -> int:
        return spin(lambda: TurtleSim(window), arguments)

    return run_in_window(parser, page, 'turtles', run, arguments)
