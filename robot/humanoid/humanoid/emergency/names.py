"""The names of the emergency stop, and its texts in refusals and results."""

from __future__ import annotations

from rclpy.clock import Clock, ClockType
from rclpy.qos import DurabilityPolicy, QoSProfile

SWITCH = 'emergency_stop'
STATE = 'emergency_stopped'
STATUS = 'emergency_stop_status'
TOLD_EVERY = 0.2  # s between repetitions, by the steady clock: a paused simulation's clock stands still
REFUSAL = f'emergency stop: nothing moves until {SWITCH} is called with false'
ENDED = 'Emergency stop'


def make_latched_qos() -> QoSProfile:
    """Return the QoS of the topics that tell the state of the emergency stop."""
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def steady() -> Clock:
    return Clock(clock_type=ClockType.STEADY_TIME)
