"""The mission's steps in the shipped house: a door closes in front of the robot, which goes round it."""

from __future__ import annotations

from humanoid.mission.robot import Robot
from humanoid.mission.steps import Report, Step, expect, watch_drive

DOOR = 'kitchen'  # to the kitchen from the living room, where the robot begins; the corridor is a second way
KITCHEN = (7.0, 3.0)  # m on the map
CLOSES_AFTER = 2.5  # m that the robot has gone; the door is then 3 m ahead
LONGER = 3.0  # m by which the way round is longer, at least
ALLOWED = 120.0  # s for a drive
GOAL_WITHIN = 130.0  # s to wait for its end


def go_round_a_closed_door(robot: Robot, report: Report) -> str:
    """Send the robot through a door, close it in front of the robot, and see it take the other way."""
    whole = through = round_it = 0.0
    with robot.drive(*KITCHEN, allowed=ALLOWED, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        for feedback in run.feedback():
            left = feedback.distance_remaining
            whole = whole or left
            report.progress(max(1.0 - left / max(whole, round_it), 0.0), f'{left:.2f} m to go')
            if through:
                round_it = max(round_it, left)
            elif whole - left >= CLOSES_AFTER:
                answer = robot.move_door(DOOR, is_open=False)
                expect(answer.success, answer.message)
                through = left
        expect(run.status == 'SUCCEEDED', f'{run.status}: {run.result.message}')
    happened = f'closed with {through:.1f} m to go; {round_it:.1f} m by the other way'
    expect(round_it > through + LONGER, happened)
    return f'{happened}; SUCCEEDED'


def go_home(robot: Robot, report: Report) -> str:
    answer = robot.move_door(DOOR, is_open=True)
    expect(answer.success, answer.message)
    with robot.drive(0.0, 0.0, allowed=ALLOWED, timeout=GOAL_WITHIN) as run:
        expect(run.accepted, 'refused')
        whole = watch_drive(run, report)
        expect(run.status == 'SUCCEEDED', f'{run.status}: {run.result.message}')
    return f'SUCCEEDED after {whole:.1f} m'


IN_HOUSE = (
    Step('to the kitchen; its door closes', 'goes round, SUCCEEDED', go_round_a_closed_door),
    Step('home, the door open again', 'SUCCEEDED', go_home),
)
