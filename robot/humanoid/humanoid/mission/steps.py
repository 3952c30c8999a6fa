"""The mission, step by step: what each does, what it expects, and what it saw."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from queue import Empty, SimpleQueue

from sensor_msgs.msg import JointState

from humanoid.emergency.names import ENDED
from humanoid.mission.calls import GoalRun
from humanoid.mission.retry import Backoff, NoAnswer, retry
from humanoid.mission.robot import Robot
from humanoid.model import JOINTS, MOVING_SPEED

MEASURED_WITHIN = 0.01  # rad: a joint with mass may stand this far beyond its limit
GOAL_WITHIN = 40.0  # s to wait for the end of a goal
ALLOWED = 30.0  # s: the time limit of a drive, for a walking robot, which turns first and is slow
ARRIVED_WITHIN = 0.05  # m: a walking robot does not stop exactly at its target
RAISED = {'left_arm_shoulder': 1.5, 'left_arm_elbow': 1.0}
LOWERED = {'left_arm_shoulder': 0.5, 'left_arm_elbow': 0.0}
GAP = 0.05  # m between the fingers of an open hand


class NotAsExpected(Exception):
    """The robot did not do what a step expected; the text says what it did."""


@dataclass(frozen=True)
class Report:
    """The functions with which a running step reports its progress and its retries."""

    progress: Callable[[float, str], None]  # arguments: the fraction done, 0 to 1, and a text
    retrying: Callable[[int, float, str], None]  # arguments: the attempt's number, the pause in s, the reason


@dataclass(frozen=True)
class Step:
    """One step; its function `run` returns a text on what happened, or raises NotAsExpected or NoAnswer."""

    name: str
    expected: str
    run: Callable[[Robot, Report], str]


def expect(truth: bool, happened: str) -> None:
    if not truth:
        raise NotAsExpected(happened)


def battery_by_retry(robot: Robot, report: Report) -> str:
    """Ask for the battery status while the service may be down: short attempts, growing pauses."""
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
    with robot.drive(1.2, 0.9, allowed=ALLOWED, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        watch_drive(run, report)
        expect(run.status == 'SUCCEEDED' and run.result.success, f'{run.status}: {run.result.message}')
        x, y = run.result.final_pose.pose.position.x, run.result.final_pose.pose.position.y
    # m: in a world the position comes from matched laser scans, less exact than the simulated odometry
    within = 0.1 if robot.in_world else ARRIVED_WITHIN
    expect(abs(x - 1.2) < within and abs(y - 0.9) < within, f'it stands at ({x:.2f}, {y:.2f}) m')
    return f'SUCCEEDED at ({x:.2f}, {y:.2f}) m'


def cancel_half_way(robot: Robot, report: Report) -> str:
    with robot.drive(4.2, 0.9, allowed=ALLOWED, timeout=GOAL_WITHIN) as run:
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
    with robot.drive(1.0, 0.0, -1.0, allowed=ALLOWED, timeout=GOAL_WITHIN) as run:
        expect(not run.accepted, 'accepted')
    return 'refused'


def pre_empt(robot: Robot, report: Report) -> str:
    with robot.drive(9.0, 9.0, allowed=30.0, timeout=GOAL_WITHIN) as older:
        expect(older.accepted, 'the older goal was refused')
        next(older.feedback(), None)
        with robot.drive(2.0, 0.9, allowed=ALLOWED, timeout=GOAL_WITHIN) as newer:
            expect(newer.accepted, 'the newer goal was refused')
            older.finish()
            expect(older.status == 'ABORTED', f'the older goal {older.status}: {older.result.message}')
            watch_drive(newer, report)
            expect(newer.status == 'SUCCEEDED', f'the newer goal {newer.status}: {newer.result.message}')
    return f'older ABORTED ({older.result.message}), newer SUCCEEDED'


def too_little_time(robot: Robot, report: Report) -> str:
    with robot.drive(9.0, 9.0, allowed=0.5, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        watch_drive(run, report)
        expect(run.status == 'ABORTED' and not run.result.success, f'{run.status}: {run.result.message}')
    return f'ABORTED: {run.result.message}'


def home_with_lowered_arm(robot: Robot, report: Report) -> str:
    """Drive home and lower the arm at the same time; compare the battery's charge before and after."""
    before = robot.battery().battery.charge
    with (
        robot.reach(LOWERED, duration=1.5, timeout=GOAL_WITHIN) as arm,
        robot.drive(0.0, 0.0, allowed=ALLOWED, timeout=GOAL_WITHIN) as base,
    ):
        expect(arm.accepted and base.accepted, 'refused')
        watch_drive(base, report)
        arm.finish()
        expect(base.status == arm.status == 'SUCCEEDED', f'base {base.status}, arm {arm.status}')
    drained = before - robot.battery().battery.charge
    expect(drained > 0.0, f'the battery gained {-1000 * drained:.1f} mAh on the way')
    return f'both SUCCEEDED, {1000 * drained:.0f} mAh drained'


def wave(robot: Robot, report: Report) -> str:
    """Make the robot wave by the service `wave`; check in the joint states that the arm moved."""
    with robot.joint_states() as states:
        _next(states)  # the first joint states must arrive before the robot waves
        answer = robot.wave(GOAL_WITHIN)
        expect(answer.success, answer.message)
        seen = [_next(states) for _ in range(states.qsize())]
    elbow = [_angle(state, 'right_arm_elbow') for state in seen]
    raised, swing = max(-_angle(state, 'right_arm_shoulder') for state in seen), max(elbow) - min(elbow)
    happened = f'{answer.message}: arm up to {raised:.2f} rad, elbow through {swing:.2f} rad'
    expect(raised > 2.0 and swing > 0.7, happened)
    report.progress(1.0, answer.message)
    return happened


def grip(robot: Robot, report: Report) -> str:
    gaps = []
    for part, gap in enumerate((GAP, 0.0), start=1):
        with robot.grip(gap, timeout=GOAL_WITHIN) as run:
            expect(run.accepted, 'refused')
            run.finish()
            expect(run.status == 'SUCCEEDED' and run.result.reached_goal, f'{run.status}: {run.result}')
        gaps.append(run.result.position)
        report.progress(part / 2, f'{gaps[-1]:.3f} m')
        expect(abs(gaps[-1] - gap) < 0.003, f'the fingers are {gaps[-1]:.3f} m apart, not {gap} m')
    return f'SUCCEEDED: {gaps[0]:.3f} m open, {gaps[1]:.3f} m closed'


def emergency_stop(robot: Robot, report: Report) -> str:
    """Throw the emergency stop during two goals, and release it again.

    Both goals must end and the robot must stand; new goals must be refused until the release.
    """
    with (
        robot.reach({'left_arm_shoulder': 2.0}, duration=10.0, timeout=GOAL_WITHIN) as arm,
        robot.drive(9.0, 9.0, allowed=30.0, timeout=GOAL_WITHIN) as base,
    ):
        expect(arm.accepted and base.accepted, 'a goal was refused before the stop')
        _go_on(base, 0.3)
        report.progress(0.2, 'under way')
        answer = robot.emergency_stop(stopped=True)
        expect(answer.success, answer.message)
        for run in (base, arm):
            run.finish()
            happened = f'{run.status}: {run.result.message}'
            expect(happened == f'ABORTED: {ENDED}', f'after the stop a goal ended {happened}')
    held = _stand_still(robot)
    report.progress(0.4, 'stands still')
    with (
        robot.drive(0.0, 0.0, allowed=ALLOWED, timeout=GOAL_WITHIN) as base,
        robot.reach(LOWERED, duration=1.5, timeout=GOAL_WITHIN) as arm,
    ):
        expect(not base.accepted and not arm.accepted, 'a stopped robot has accepted a goal')
    moved = max(abs(was - now) for was, now in zip(held.position, _stand_still(robot).position, strict=True))
    expect(moved < MEASURED_WITHIN, f'a stopped joint has moved by {moved:.3f}')
    answer = robot.emergency_stop(stopped=False)
    expect(answer.success, answer.message)
    report.progress(0.6, 'released')
    with (
        _once_released(lambda: robot.drive(0.0, 0.0, allowed=ALLOWED, timeout=GOAL_WITHIN), report) as base,
        _once_released(lambda: robot.reach(LOWERED, duration=1.5, timeout=GOAL_WITHIN), report) as arm,
    ):
        base.finish()
        arm.finish()
        expect(base.status == arm.status == 'SUCCEEDED', f'released: base {base.status}, arm {arm.status}')
    return 'both ABORTED, both refused; released: both SUCCEEDED'


def _go_on(run: GoalRun, way: float) -> None:
    """Wait until the base has gone `way` m."""
    whole = None
    for feedback in run.feedback():
        whole = whole or feedback.distance_remaining
        if whole - feedback.distance_remaining >= way:
            return
    raise NotAsExpected(f'the drive ended before it had gone {way} m: {run.status}')


def _stand_still(robot: Robot) -> JointState:
    """Wait until no joint moves; return the joint state that shows it."""
    deadline = time.monotonic() + GOAL_WITHIN
    with robot.joint_states() as states:
        while time.monotonic() < deadline:
            state = _next(states)
            if all(abs(speed) < MOVING_SPEED for speed in state.velocity):
                return state
    raise NotAsExpected(f'stopped for {GOAL_WITHIN:.0f} s, and its joints still move')


def _once_released(send: Callable[[], GoalRun], report: Report) -> GoalRun:
    """Send a goal until it is accepted: servers hear of the stop's release by a topic, a little later."""

    def attempt(_seconds: float) -> GoalRun:
        run = send()
        if not run.accepted:
            raise NoAnswer('released, but still refused')
        return run

    run, _ = retry(
        attempt,
        attempt_timeout=GOAL_WITHIN,
        timeout=GOAL_WITHIN,
        backoff=Backoff(),
        on_retry=lambda number, pause, why: report.retrying(number, pause, str(why)),
    )
    return run


def _next(states: SimpleQueue[JointState]) -> JointState:
    try:
        return states.get(timeout=GOAL_WITHIN)
    except Empty:
        raise NoAnswer(f'joint_states: no message within {GOAL_WITHIN:.1f} s') from None


def _angle(state: JointState, joint: str) -> float:
    return state.position[list(state.name).index(joint)]


def watch_drive(run: GoalRun, report: Report) -> float:
    """Report the progress of a drive to its end; return the way at its beginning, in m."""
    whole = 0.0
    for feedback in run.feedback():
        left = feedback.distance_remaining
        whole = whole or left
        report.progress(1.0 - left / whole if whole else 1.0, f'{left:.2f} m to go')
    return whole


def steps(*, battery_starts_late: bool = False, whole_body: bool = False) -> Sequence[Step]:
    """Return the ten steps of the mission; with `whole_body` three more: wave, grip, emergency stop.

    `battery_starts_late`: the battery service is expected to start only after the first attempt to call it.
    """
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
        *(WHOLE_BODY if whole_body else ()),
    ]


WHOLE_BODY = (
    Step('wave', 'waved, seen in the joints', wave),
    Step('open and close the left hand', 'both SUCCEEDED', grip),
    Step('emergency stop', 'goals ABORTED, refused until released', emergency_stop),
)
