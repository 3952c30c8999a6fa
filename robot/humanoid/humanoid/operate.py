"""Commands for a person at the command line: show the robot's state, wave, move the base or a joint."""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from difflib import get_close_matches
from queue import SimpleQueue
from types import FrameType
from typing import NoReturn, TypeVar

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3
from humanoid_interfaces.srv import Push
from nav_msgs.msg import Odometry
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

from humanoid.emergency.names import REFUSAL, STATUS, make_latched_qos
from humanoid.emergency.votes import GONE
from humanoid.gestures import WAVE, time_unhurried
from humanoid.mission.calls import GoalRun, call
from humanoid.mission.home import drive_home
from humanoid.mission.retry import NoAnswer
from humanoid.mission.robot import ANSWER_WITHIN, Robot
from humanoid.model import JOINT_BY_NAME, JOINTS, MOVING_SPEED
from humanoid.navigation.base import yaw_of
from humanoid.text import brief
from humanoid.walking.names import BALANCES, BALANCING, FALLEN, GET_UP, LIES, PUSH

WATCH_EVERY = 1.0  # s
GOAL_OVERHEAD = 5.0  # s to wait for the result after the goal's own time limit
ARRIVED, FAILED, STOPPED = 0, 1, 130

Told = TypeVar('Told')


class Impossible(Exception):
    """The request cannot be carried out; the text says why, and what can be asked for instead."""


def operate(options: argparse.Namespace, ros_args: list[str]) -> int:
    """Carry out one of COMMANDS; return the exit code. Ctrl-C cancels the goal and waits for its end."""
    # This program itself handles Ctrl-C, not ROS: running goals are cancelled before ROS shuts down.
    try:
        rclpy.init(
            args=[*(ros_args or ['--ros-args']), *_namespace(options.name)],
            signal_handler_options=SignalHandlerOptions.NO,
        )
    except RuntimeError as error:  # the arguments for ROS 2 are invalid
        return _complain(options.command, brief(str(error)))
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        with Robot(f'operator_{os.getpid()}') as robot:  # a unique name: several operators may run
            return COMMANDS[options.command](robot, options)
    except KeyboardInterrupt:
        print('stopped')
        return STOPPED
    except Impossible as refusal:
        return _complain(options.command, str(refusal))
    except NoAnswer as silence:
        return _complain(options.command, f'{silence}; is the robot up? start it with: humanoid up')
    finally:
        rclpy.try_shutdown()


def _namespace(name: str | None) -> list[str]:
    return ['-r', f'__ns:=/{name}'] if name else []


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


def _complain(command: str, problem: str) -> int:
    print(f'humanoid {command}: {problem}', file=sys.stderr)
    return FAILED


def status(robot: Robot, _options: argparse.Namespace) -> int:
    """Show the joints, the base and the battery."""
    for joint in JOINTS:
        state = robot.joint(joint.name)
        motion = 'moving' if state.is_moving else 'still'
        unit, push = joint.unit, 'N' if joint.prismatic else 'N·m'
        speed = f'{state.velocity:7.3f} {unit}/s'
        effort = f'{state.effort:7.2f} {push}'
        print(f'{joint.name:24} {state.position:7.3f} {unit:3} {speed:13} {effort:11}  {motion}')
    print(_base(_odometry(robot)))
    answer = robot.battery()
    minutes = answer.time_remaining.sec // 60
    battery = answer.battery
    print(
        f'battery {battery.percentage:.0%}, {battery.voltage:.1f} V, {battery.current:.1f} A, '
        f'empty in {minutes // 60} h {minutes % 60:02} min'
    )
    return ARRIVED


def _odometry(robot: Robot) -> Odometry:
    """Return where the base is. Raises NoAnswer."""
    return robot.next_message(Odometry, 'odom')


def _explain_refusal(robot: Robot, otherwise: str, joints: Collection[str] = ()) -> str:
    """Return why a goal was probably refused: the emergency stop, the balance, else `otherwise`."""
    try:
        status = robot.next_message(DiagnosticStatus, STATUS, make_latched_qos())
    except NoAnswer:
        return f'the goal was refused: {otherwise}; or the emergency stop: {GONE}'
    if status.level != DiagnosticStatus.OK:
        return f'the goal was refused: {REFUSAL} ({brief(status.message)})'
    return f'the goal was refused: {_balance(robot, joints) or otherwise}'


def _balance(robot: Robot, joints: Collection[str]) -> str:
    """Return why a walking robot refuses a goal; '' if it does not, or if the robot cannot walk."""
    if not robot.node.count_publishers(FALLEN):
        return ''
    if robot.next_message(Bool, FALLEN, make_latched_qos()).data:
        return LIES
    kept = robot.next_message(String, BALANCING, make_latched_qos()).data.split(',')
    return next((f'{joint} {BALANCES}' for joint in joints if joint in kept), '')


def _base(odometry: Odometry) -> str:
    where, speed = odometry.pose.pose.position, odometry.twist.twist.linear
    return f'base at ({where.x:.2f}, {where.y:.2f}) m, {(speed.x**2 + speed.y**2) ** 0.5:.2f} m/s'


def move(robot: Robot, options: argparse.Namespace) -> int:
    """Send the base to (x, y) on the map, or on the floor of `odom` if there is none."""
    allowed = options.timeout
    timeout = allowed + GOAL_OVERHEAD
    goal = robot.drive(options.x, options.y, allowed=allowed, timeout=timeout, frame=options.frame or '')
    return _drive(robot, goal, 'at')


def home(robot: Robot, options: argparse.Namespace) -> int:
    """Drive the base back to where the robot was brought up."""
    return _drive(robot, drive_home(robot, _odometry(robot), options.timeout), 'home: at')


def _drive(robot: Robot, drive: GoalRun, arrived: str) -> int:
    """Show a drive's progress and its result; return the exit code."""
    began = time.monotonic()
    with drive as goal:
        if not goal.accepted:
            raise Impossible(_explain_refusal(robot, 'the target must be within 1000 m, the time positive'))
        for feedback in goal.feedback():
            _progress(f'{feedback.distance_remaining:.2f} m to go')
    _progress('')
    here = goal.result.final_pose.pose.position
    at = 'at' if goal.status != 'SUCCEEDED' else arrived
    return _report_end(goal, f'{at} ({here.x:.2f}, {here.y:.2f}) m after {time.monotonic() - began:.1f} s')


def arm(robot: Robot, options: argparse.Namespace) -> int:
    """Move one joint to an angle in rad."""
    spec = JOINT_BY_NAME.get(options.joint)
    if spec is None:
        near = get_close_matches(options.joint, JOINT_BY_NAME, 1)
        advice = f"did you mean '{near[0]}'?" if near else f'there are {", ".join(JOINT_BY_NAME)}'
        raise Impossible(f"there is no joint '{brief(options.joint)}'; {advice}")
    goal = _reach(robot, {options.joint: options.position}, options.duration)
    return _report_end(goal, f'{options.joint} at {goal.result.final_positions[0]:.3f} {spec.unit}')


def wave(robot: Robot, _options: argparse.Namespace) -> int:
    """Raise the right arm, wave, and take it down again."""
    for movement in WAVE:
        goal = _reach(robot, movement)
        if goal.status != 'SUCCEEDED':
            return _report_end(goal, 'waving')
    print('waved')
    return ARRIVED


def door(robot: Robot, options: argparse.Namespace) -> int:
    """Open or close a door of the world."""
    there = robot.doors()
    if options.door not in there:
        advice = f'there are {", ".join(there)}' if there else 'the robot is in no world with doors'
        raise Impossible(f"there is no door '{brief(options.door)}'; {advice}")
    answer = robot.move_door(options.door, is_open=options.wish == 'open')
    if not answer.success:
        raise Impossible(answer.message)
    print(answer.message)
    return ARRIVED


def push(robot: Robot, options: argparse.Namespace) -> int:
    """Push the pelvis of a simulated robot; the direction is relative to the robot's heading."""
    turn = _odometry(robot).pose.pose.orientation
    way = yaw_of(turn.x, turn.y, turn.z, turn.w) + math.radians(options.direction)
    force = Vector3(x=options.force * math.cos(way), y=options.force * math.sin(way))
    client = robot.node.create_client(Push, PUSH)
    return _answered(call(client, Push.Request(force=force, duration=options.duration), ANSWER_WITHIN))


def get_up(robot: Robot, _options: argparse.Namespace) -> int:
    """Put a simulated robot that has fallen back on its feet."""
    client = robot.node.create_client(Trigger, GET_UP)
    return _answered(call(client, Trigger.Request(), ANSWER_WITHIN))


def _answered(answer: Push.Response | Trigger.Response) -> int:
    print(brief(answer.message), file=sys.stdout if answer.success else sys.stderr)
    return ARRIVED if answer.success else FAILED


def _reach(robot: Robot, angles: Mapping[str, float], duration: float | None = None) -> GoalRun:
    """Move joints in `duration` s, by default at an unhurried speed, and wait until they have arrived."""
    if duration is None:
        duration = time_unhurried(angles, {name: robot.joint(name).position for name in angles})
    with robot.reach(angles, duration=duration, timeout=duration + GOAL_OVERHEAD) as goal:
        if not goal.accepted:
            limits = ', '.join(
                f'{joint.name} goes from {joint.lower} to {joint.upper} {joint.unit}, '
                f'{joint.max_velocity} {joint.unit}/s at most'
                for joint in map(JOINT_BY_NAME.__getitem__, angles)
            )
            raise Impossible(_explain_refusal(robot, limits, angles))
        for feedback in goal.feedback():
            _progress(f'{feedback.fraction_done:.0%}')
    _progress('')
    return goal


def _progress(text: str) -> None:
    """Show the progress on a terminal; '' clears the line."""
    if sys.stdout.isatty():
        print(f'\r\033[K{text}', end='', flush=True)


def _report_end(goal: GoalRun, where: str) -> int:
    if goal.status == 'SUCCEEDED':
        print(where)
        return ARRIVED
    print(f'{goal.status.lower()}: {brief(goal.result.message)}; {where}', file=sys.stderr)
    return FAILED


def watch(robot: Robot, _options: argparse.Namespace) -> NoReturn:
    """Print a line a second: the base, and the joints that move. Raises NoAnswer if the robot is gone."""
    ticks: SimpleQueue[None] = SimpleQueue()
    states: deque[JointState] = deque(maxlen=1)
    bases: deque[Odometry] = deque(maxlen=1)
    robot.node.create_subscription(JointState, 'joint_states', states.append, 1)
    robot.node.create_subscription(Odometry, 'odom', bases.append, 1)
    robot.node.create_timer(WATCH_EVERY, lambda: ticks.put(None))
    silent = 0.0
    while True:
        ticks.get()
        if not (states and bases):
            silent += WATCH_EVERY
            if silent > ANSWER_WITHIN:
                raise NoAnswer(f'joint_states, odom: no message within {silent:.1f} s')
            continue
        silent = 0.0
        state, base = states.pop(), bases.pop()
        moving = [
            f'{name} {position:.2f} {JOINT_BY_NAME[name].unit if name in JOINT_BY_NAME else ""}'
            for name, position, velocity in zip(state.name, state.position, state.velocity, strict=True)
            if abs(velocity) > MOVING_SPEED
        ]
        print(f'{_base(base)}; {", ".join(moving) or "joints still"}', flush=True)


COMMANDS: dict[str, Callable[[Robot, argparse.Namespace], int]] = {
    'status': status,
    'wave': wave,
    'move': move,
    'home': home,
    'arm': arm,
    'door': door,
    'push': push,
    'get_up': get_up,
    'watch': watch,
}
