"""A bag of a robot that drives along x, waves, speaks, and has two goals. Times are in s from START."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from builtin_interfaces.msg import Time
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import TransformStamped
from helpers.bags import START
from helpers.markdown import ROOT
from rcl_interfaces.msg import Log
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, String
from tf2_msgs.msg import TFMessage

from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import DurabilityPolicy, QoS

SECONDS = 60
RATE = 20
GOALS = {bytes(range(16)): (10, 20, 4), bytes(range(16, 32)): (30, 45, 6)}
"""By id: when it began and ended, and its last status, SUCCEEDED or ABORTED."""
SPEED = 0.05
_LATCHED = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_TYPES = {
    '/robot_description': 'std_msgs/msg/String',
    '/tf': 'tf2_msgs/msg/TFMessage',
    '/tf_static': 'tf2_msgs/msg/TFMessage',
    '/joint_states': 'sensor_msgs/msg/JointState',
    '/load': 'std_msgs/msg/Float64',
    '/rosout': 'rcl_interfaces/msg/Log',
    '/count/_action/status': 'action_msgs/msg/GoalStatusArray',
    '/count/_action/feedback': 'example_interfaces/action/Fibonacci_FeedbackMessage',
}


def write_recorded_robot(path: Path, seconds: int = SECONDS, **options: Any) -> Path:
    """Write the bag and return its path; the description and /tf_static are at its start alone."""
    with Writer(path, **options) as bag:
        for topic, type_name in _TYPES.items():
            bag.add_topic(topic, type_name, qos=[_LATCHED] if 'static' in topic else [])

        def put(topic: str, message: Any, at: float) -> None:
            bag.write(topic, serialize_message(message), START + round(at * 1e9))

        put('/robot_description', String(data=(ROOT / 'tests/data/robot.urdf').read_text()), 0.0)
        put('/tf_static', TFMessage(transforms=[_frame('map', 'odom', 1.0)]), 0.0)
        for tick in range(seconds * RATE + 1):
            at = tick / RATE
            put('/tf', TFMessage(transforms=[_frame('odom', 'base_link', SPEED * at)]), at)
            put('/joint_states', JointState(name=['left_joint'], position=[at / seconds]), at)
            put('/load', Float64(data=90.0 if tick == 500 else 10.0), at)
            if tick % RATE == 0:
                put('/rosout', _line(int(at)), at)
                _put_goals(put, int(at))
    return path


def _put_goals(put: Any, second: int) -> None:
    status = GoalStatusArray()
    for goal_id, (began, ended, last) in GOALS.items():
        if second < began:
            continue
        info = GoalInfo(stamp=Time(sec=START // 1_000_000_000 + began))
        info.goal_id.uuid = list(goal_id)
        status.status_list.append(GoalStatus(goal_info=info, status=last if second >= ended else 2))
        if second < ended:
            feedback = Fibonacci.Impl.FeedbackMessage(feedback=Fibonacci.Feedback(sequence=[second]))
            feedback.goal_id.uuid = list(goal_id)
            put('/count/_action/feedback', feedback, second + 0.5)
    put('/count/_action/status', status, second)


def _frame(parent: str, child: str, x: float) -> TransformStamped:
    frame = TransformStamped(child_frame_id=child)
    frame.header.frame_id = parent
    frame.transform.translation.x = x
    frame.transform.rotation.w = 1.0
    return frame


def _line(second: int) -> Log:
    stamp = Time(sec=START // 1_000_000_000 + second)
    return Log(stamp=stamp, level=20, name='robot', msg=f'second {second} has come')
