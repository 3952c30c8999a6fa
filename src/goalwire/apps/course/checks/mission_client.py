"""Exercise 3: the program asks for the battery, then moves the arm; its exit code says how that went."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import goalwire
from goalwire.apps.course.bench import alone, wait_for_node
from goalwire.apps.course.student import Student, Wrong

if TYPE_CHECKING:
    from humanoid_interfaces.action import MoveArm
    from humanoid_interfaces.srv import GetBatteryStatus

    Goal: TypeAlias = 'goalwire.Goal[MoveArm.Goal, MoveArm.Feedback]'

SERVICE, ACTION = 'get_battery_status', 'move_arm'
LEAST_CHARGE = 0.2
LIMIT = 3.0
"""s that the task gives the arm."""
ENDS_WITHIN = 8.0
"""s from the time when its node is there; what it does takes half of that at most."""


class Robot:
    """The robot that the program under test talks to: its battery, its arm, and what was asked of them."""

    def __init__(self, percentage: float, arm: Callable[[Goal], Awaitable[MoveArm.Result]]) -> None:
        self._percentage = percentage
        self._arm = arm
        self.refuses = False
        self.seen: list[str] = []
        """'battery' and 'goal', in the order in which the program asked."""
        self.cancelled = False

    def serve(self, node: goalwire.Node) -> None:
        """Offer the service and the action."""
        from humanoid_interfaces.action import MoveArm
        from humanoid_interfaces.srv import GetBatteryStatus

        node.service(GetBatteryStatus, SERVICE, self._tell)
        node.action_server(MoveArm, ACTION, self._move, accept=self._accept)

    def _tell(self, _request: GetBatteryStatus.Request) -> GetBatteryStatus.Response:
        from humanoid_interfaces.srv import GetBatteryStatus
        from sensor_msgs.msg import BatteryState

        self.seen.append('battery')
        return GetBatteryStatus.Response(battery=BatteryState(percentage=self._percentage, present=True))

    def _accept(self, _goal: MoveArm.Goal) -> bool:
        self.seen.append('goal')
        return not self.refuses

    async def _move(self, goal: Goal) -> MoveArm.Result:
        try:
            return await self._arm(goal)
        except asyncio.CancelledError:
            self.cancelled = True
            raise


async def steps(file: Path) -> AsyncIterator[str]:
    """Yield what the program does as it should; raise Wrong at the first thing that it does not."""
    async with _mission(file, 0.8, _arrive) as (robot, student):
        code = await student.wait(
            ENDS_WITHIN,
            'it has to end by itself: wait for the result with spin_until_future_complete, not spin',
        )
        _judge_order(robot.seen)
        if code != 0:
            raise Wrong(
                f'all went well, but the exit code is {code}', f'it should be 0\n{student.last_lines()}'
            )
        yield 'it asks for the battery, moves the arm, and ends with exit code 0'
        if '50' not in student.output:
            raise Wrong(
                'the arm said that it was half way, and the program did not show it',
                'give send_goal_async a feedback_callback that prints fraction_done in percent',
            )
        yield 'it shows the feedback in percent'
    async with _mission(file, 0.1, _arrive) as (robot, student):
        case = 'the battery is at 10 %'
        code = await _end(student, case)
        if 'goal' in robot.seen:
            raise Wrong(
                'the arm was moved although the battery is at 10 %',
                f'send no goal below {LEAST_CHARGE:.0%}: percentage < {LEAST_CHARGE}',
            )
        _judge_failure(code, case)
        yield 'it does not move the arm if the battery is low, and its exit code says so'
    async with _mission(file, 0.8, _arrive, refuses=True) as (_, student):
        await _insist_on_failure(student, 'the arm refuses the goal')
        yield 'its exit code says that the goal was refused'
    async with _mission(file, 0.8, _fail) as (_, student):
        await _insist_on_failure(student, 'the arm gets stuck, and the goal ends ABORTED')
        yield 'its exit code says that the goal failed'
    async with _mission(file, 0.8, _hang) as (robot, student):
        await _insist_on_failure(student, 'the arm does not arrive')
        if not robot.cancelled:
            raise Wrong(
                f'the program gave up after {LIMIT:g} s, and the arm still moves',
                'cancel the goal: goal_handle.cancel_goal_async(), and wait for the answer',
            )
        yield f'it cancels a goal that takes longer than {LIMIT:g} s'


@asynccontextmanager
async def _mission(
    file: Path,
    percentage: float,
    arm: Callable[[Goal], Awaitable[MoveArm.Result]],
    *,
    refuses: bool = False,
) -> AsyncIterator[tuple[Robot, Student]]:
    """Run the program beside a robot, whose servers come a moment after it."""
    robot = Robot(percentage, arm)
    robot.refuses = refuses
    async with alone() as node, Student(file) as student:
        await wait_for_node(node, student)
        robot.serve(node)
        yield robot, student


def _judge_order(seen: list[str]) -> None:
    if 'battery' not in seen:
        raise Wrong(
            'the program ended without asking for the battery',
            f'call {SERVICE!r} first; wait_for_service() waits until it is there',
        )
    if 'goal' not in seen:
        raise Wrong('the program ended without a goal for the arm', f'send one to {ACTION!r}')
    if seen[0] != 'battery':
        raise Wrong(
            'the goal was sent before the battery was known', 'wait for the answer of the service first'
        )
    if seen.count('goal') > 1:
        raise Wrong(f'{seen.count("goal")} goals were sent', 'one is enough')


async def _insist_on_failure(student: Student, case: str) -> None:
    _judge_failure(await _end(student, case), case)


async def _end(student: Student, case: str) -> int:
    return await student.wait(ENDS_WITHIN, f'it has to end by itself if {case}')


def _judge_failure(code: int, case: str) -> None:
    if code == 0:
        raise Wrong(
            f'{case}, and the exit code is 0', 'whoever started the program relies on it: sys.exit(1)'
        )


async def _arrive(goal: Goal) -> MoveArm.Result:
    from humanoid_interfaces.action import MoveArm

    for fraction in (0.25, 0.5, 1.0):
        goal.feedback(
            joint_names=goal.request.joint_names, positions=goal.request.positions, fraction_done=fraction
        )
        await asyncio.sleep(0.1)
    return MoveArm.Result(final_positions=goal.request.positions, success=True, message='arrived')


async def _fail(_goal: Goal) -> MoveArm.Result:
    from humanoid_interfaces.action import MoveArm

    raise goalwire.GoalAborted('the arm is stuck', result=MoveArm.Result(message='stuck'))


async def _hang(_goal: Goal) -> MoveArm.Result:
    await asyncio.Event().wait()
    raise AssertionError
