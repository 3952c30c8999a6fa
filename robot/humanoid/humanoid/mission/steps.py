"""The mission, step by step: what each does, what it expects, and what it saw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from humanoid.mission.calls import GoalRun
from humanoid.mission.retry import Backoff, retry
from humanoid.mission.robot import Robot
from humanoid.model import JOINTS

MEASURED_WITHIN = 0.01  # rad: a joint that has mass stands at its stop only about
GOAL_WITHIN = 12.0  # s for a whole goal of this mission
RAISED = {'left_arm_shoulder': 1.5, 'left_arm_elbow': 1.0}
LOWERED = {'left_arm_shoulder': 0.5, 'left_arm_elbow': 0.0}


class NotAsExpected(Exception):
    """The robot did something else; the text says what."""


@dataclass(frozen=True)
class Report:
    """What a step may tell while it runs."""

    progress: Callable[[float, str], None]  # fraction 0 to 1, text
    retrying: Callable[[int, float, str], None]  # attempt, pause in s, reason


@dataclass(frozen=True)
class Step:
    """`run` returns what happened, or raises NotAsExpected or NoAnswer."""

    name: str
    expected: str
    run: Callable[[Robot, Report], str]


def expect(truth: bool, happened: str) -> None:
    if not truth:
        raise NotAsExpected(happened)


def battery_by_retry(robot: Robot, report: Report) -> str:
    """The service may still be down: short attempts, growing pauses."""
    status, attempts = retry(
        robot.battery,
        attempt_timeout=0.5,
        timeout=10.0,
        backoff=Backoff(),
        on_retry=lambda attempt, pause, why: report.retrying(attempt, pause, str(why)),
    )
    expect(0.0 < status.battery.percentage <= 1.0, f'a charge of {status.battery.percentage:.3f}')
    minutes = status.time_remaining.sec // 60
    return f'{status.battery.percentage:.1%} on attempt {attempts}, {minutes} min left'


def battery_late(robot: Robot, report: Report) -> str:
    attempts = 1

    def retrying(attempt: int, pause: float, why: str) -> None:
        nonlocal attempts
        attempts = attempt + 1
        report.retrying(attempt, pause, why)

    happened = battery_by_retry(robot, Report(report.progress, retrying))
    expect(attempts > 1, f'{happened}: it was up at once')
    return happened


def every_joint(robot: Robot, report: Report) -> str:
    for number, joint in enumerate(JOINTS, start=1):
        state = robot.joint(joint.name)
        report.progress(number / len(JOINTS), f'{joint.name} at {state.position:.2f} {joint.unit}')
        within = joint.lower - MEASURED_WITHIN <= state.position <= joint.upper + MEASURED_WITHIN
        expect(within, f'{joint.name} at {state.position} {joint.unit}')
    unknown = robot.joint('tail')
    expect(unknown.position == 0.0 and not unknown.is_moving, f'a joint that is not there: {unknown}')
    return f'{len(JOINTS)} joints within limits, zeros for an unknown one'


def raise_arm(robot: Robot, report: Report) -> str:
    seen_moving = False
    with robot.reach(RAISED, duration=1.5, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        for feedback in run.feedback():
            report.progress(feedback.fraction_done, f'shoulder at {feedback.positions[0]:.2f} rad')
            seen_moving = seen_moving or robot.joint('left_arm_shoulder').is_moving
        expect(run.status == 'SUCCEEDED', f'{run.status}: {run.result.message}')
    shoulder = robot.joint('left_arm_shoulder').position
    expect(abs(shoulder - RAISED['left_arm_shoulder']) < 0.02, f'the shoulder stands at {shoulder:.3f} rad')
    expect(seen_moving, 'the shoulder was never seen moving')
    return f'SUCCEEDED, shoulder seen moving, now at {shoulder:.2f} rad'


def arm_beyond_limits(robot: Robot, _report: Report) -> str:
    with robot.reach({'left_arm_elbow': 9.0}, duration=10.0, timeout=GOAL_WITHIN) as run:
        expect(not run.accepted, 'accepted')
    return 'refused'


def drive(robot: Robot, report: Report) -> str:
    with robot.drive(1.2, 0.9, allowed=10.0, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        _watch_drive(run, report)
        expect(run.status == 'SUCCEEDED' and run.result.success, f'{run.status}: {run.result.message}')
        x, y = run.result.final_pose.pose.position.x, run.result.final_pose.pose.position.y
    expect(abs(x - 1.2) < 0.01 and abs(y - 0.9) < 0.01, f'it stands at ({x:.2f}, {y:.2f}) m')
    return f'SUCCEEDED at ({x:.2f}, {y:.2f}) m'


def cancel_half_way(robot: Robot, report: Report) -> str:
    with robot.drive(4.2, 0.9, allowed=10.0, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        whole = None
        for feedback in run.feedback():
            left = feedback.distance_remaining
            whole = whole or left
            report.progress(1.0 - left / whole, f'{left:.2f} m to go')
            if left <= whole / 2:
                break
        run.cancel()
        run.finish()
        expect(run.status == 'CANCELED', f'{run.status}: {run.result.message}')
        x = run.result.final_pose.pose.position.x
    expect(2.4 < x < 4.0, f'CANCELED at x = {x:.2f} m, half-way is 2.70 m')
    return f'CANCELED at x = {x:.2f} m'


def drive_below_floor(robot: Robot, _report: Report) -> str:
    with robot.drive(1.0, 0.0, -1.0, allowed=10.0, timeout=GOAL_WITHIN) as run:
        expect(not run.accepted, 'accepted')
    return 'refused'


def pre_empt(robot: Robot, report: Report) -> str:
    with robot.drive(9.0, 9.0, allowed=30.0, timeout=GOAL_WITHIN) as older:
        expect(older.accepted, 'the older goal was refused')
        next(older.feedback(), None)
        with robot.drive(2.0, 0.9, allowed=10.0, timeout=GOAL_WITHIN) as newer:
            expect(newer.accepted, 'the newer goal was refused')
            older.finish()
            expect(older.status == 'ABORTED', f'the older goal {older.status}: {older.result.message}')
            _watch_drive(newer, report)
            expect(newer.status == 'SUCCEEDED', f'the newer goal {newer.status}: {newer.result.message}')
    return f'older ABORTED ({older.result.message}), newer SUCCEEDED'


def too_little_time(robot: Robot, report: Report) -> str:
    with robot.drive(9.0, 9.0, allowed=0.5, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        _watch_drive(run, report)
        expect(run.status == 'ABORTED' and not run.result.success, f'{run.status}: {run.result.message}')
    return f'ABORTED: {run.result.message}'


def home_with_lowered_arm(robot: Robot, report: Report) -> str:
    """Two actions at once, and a service before and after them."""
    before = robot.battery().battery.charge
    with (
        robot.reach(LOWERED, duration=1.5, timeout=GOAL_WITHIN) as arm,
        robot.drive(0.0, 0.0, allowed=10.0, timeout=GOAL_WITHIN) as base,
    ):
        expect(arm.accepted and base.accepted, 'refused')
        _watch_drive(base, report)
        arm.finish()
        expect(base.status == arm.status == 'SUCCEEDED', f'base {base.status}, arm {arm.status}')
    drained = before - robot.battery().battery.charge
    expect(drained > 0.0, f'the battery gained {-1000 * drained:.1f} mAh on the way')
    return f'both SUCCEEDED, {1000 * drained:.0f} mAh drained'


def _watch_drive(run: GoalRun, report: Report) -> None:
    whole = None
    for feedback in run.feedback():
        left = feedback.distance_remaining
        whole = whole or left
        report.progress(1.0 - left / whole if whole else 1.0, f'{left:.2f} m to go')


def steps(*, battery_starts_late: bool = False) -> Sequence[Step]:
    """`battery_starts_late`: the battery service is started only after the mission has missed it."""
    battery = (
        Step('battery, down at first', 'answers on a retry', battery_late)
        if battery_starts_late
        else Step('battery', 'answers, by retry if need be', battery_by_retry)
    )
    return [
        battery,
        Step('ask every joint', 'all within their limits', every_joint),
        Step('raise the left arm', 'SUCCEEDED, seen moving', raise_arm),
        Step('arm beyond its limits', 'refused', arm_beyond_limits),
        Step('drive to (1.2, 0.9)', 'SUCCEEDED', drive),
        Step('drive, cancel half-way', 'CANCELED half-way', cancel_half_way),
        Step('drive below the floor', 'refused', drive_below_floor),
        Step('newer goal while driving', 'older ABORTED, newer SUCCEEDED', pre_empt),
        Step('drive with too little time', 'ABORTED, success=False', too_little_time),
        Step('home, lowering the arm', 'both SUCCEEDED, battery drained', home_with_lowered_arm),
    ]
