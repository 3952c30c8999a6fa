"""The mission as a program: runs the steps, shows them, and exits 0 only if each ended as it should."""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Sequence
from types import FrameType

import rclpy
from nav_msgs.msg import Odometry
from rclpy.signals import SignalHandlerOptions

from humanoid.mission.display import display
from humanoid.mission.events import Began, Event, Finished, Progressed, Retrying, Sink, to_line
from humanoid.mission.home import distance_home, drive_home, is_at_home
from humanoid.mission.house import IN_HOUSE
from humanoid.mission.retry import NoAnswer
from humanoid.mission.robot import Robot
from humanoid.mission.steps import NotAsExpected, Report, Step, expect, steps
from humanoid.mission.summary import Summary
from humanoid.running import join


def carry_out(robot: Robot, mission: Sequence[Step], tell: Sink) -> None:
    """Run all steps in order; a step that fails does not stop the others."""
    for number, step in enumerate(mission, start=1):
        tell(Began(number, len(mission), step.name, step.expected))
        began = time.monotonic()
        try:
            ok, happened = True, step.run(robot, _report(number, tell))
        except (NotAsExpected, NoAnswer) as failure:
            ok, happened = False, str(failure)
        tell(Finished(number, ok, happened, time.monotonic() - began))


def _report(number: int, tell: Sink) -> Report:
    """Return the Report for step `number`."""
    return Report(
        lambda fraction, text: tell(Progressed(number, fraction, text)),
        lambda attempt, wait, reason: tell(Retrying(number, attempt, wait, reason)),
    )


def main(args: Sequence[str] | None = None) -> int:
    options, ros_args = _parser().parse_known_args(args)
    mission = [
        *steps(battery_starts_late=options.battery_starts_late, whole_body=options.whole_body),
        *(IN_HOUSE if options.in_house else ()),
    ]
    # The mission itself handles Ctrl-C, not ROS: running goals are cancelled before ROS shuts down.
    join(ros_args, SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, _interrupt)
    summary = Summary(len(mission))
    try:
        with Robot() as robot:
            _begin_at_home(robot)
            if options.events:
                carry_out(robot, mission, lambda event: _tell(summary, _print_line, event))
            else:
                with display() as show:
                    carry_out(robot, mission, lambda event: _tell(summary, show, event))
                print(summary.table())
    except KeyboardInterrupt:
        print('mission stopped: its goals were cancelled')
        return 130
    except (NotAsExpected, NoAnswer) as failure:
        print(f'mission: {failure}', file=sys.stderr)
        return 1
    finally:
        rclpy.try_shutdown()
    return 0 if summary.all_well else 1


def _begin_at_home(robot: Robot) -> None:
    """Drive home first if the base is somewhere else: the mission's steps expect to begin at home.

    If the base publishes no position, the mission begins where the base stands. Raises NotAsExpected and
    NoAnswer.
    """
    try:
        odometry = robot.next_message(Odometry, 'odom')
    except NoAnswer:
        return
    if is_at_home(odometry):
        return
    print(f'the base is {distance_home(odometry):.2f} m from home: it drives there first', flush=True)
    with drive_home(robot, odometry) as run:
        expect(run.accepted, 'the base cannot drive home: refused; see the log of navigation_action_server')
        run.finish()
    expect(run.status == 'SUCCEEDED', f'the base did not come home: {run.status}: {run.result.message}')


def _tell(summary: Summary, show: Sink, event: Event) -> None:
    summary.note(event)
    show(event)


def _print_line(event: Event) -> None:
    print(to_line(event), flush=True)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='mission', description=__doc__)
    parser.add_argument('--events', action='store_true', help='print what happens as one JSON record a line')
    parser.add_argument(
        '--battery-starts-late',
        action='store_true',
        help='expect the battery service to be down at first (humanoid demo starts it later)',
    )
    parser.add_argument(
        '--whole-body',
        action='store_true',
        help='three steps more: wave, open and close a hand, be stopped and released',
    )
    parser.add_argument(
        '--in-house',
        action='store_true',
        help='two steps more, in the world house: to the kitchen, whose door closes on the way, and home',
    )
    return parser


if __name__ == '__main__':
    raise SystemExit(main())
