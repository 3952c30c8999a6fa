"""Exercise 3: the program asks for the battery, then moves the arm; its exit code says how that went."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import goalwire
from goalwire.apps.course.bench import alone, wait_for_node
from goalwire.apps.course.student import Student, Wrong
from goalwire.rules.names.actions import ActionNames
from goalwire.rules.qos import ACTION_STATUS_DEFAULT

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from humanoid_interfaces.action import MoveArm
    from humanoid_interfaces.srv import GetBatteryStatus

    Goal: TypeAlias = 'goalwire.Goal[MoveArm.Goal, MoveArm.Feedback]'
    Arm: TypeAlias = 'Callable[[Goal], Awaitable[MoveArm.Result]] | Reluctant'

SERVICE, ACTION = 'get_battery_status', 'move_arm'
LEAST_CHARGE = 0.2
LATE = 0.7
"""Seconds until the service appears, and then from the first request until the action appears."""
ASKS_WITHIN = 2.0
"""Seconds after which the arm appears even if the program never asks for the battery."""
CANCELS_AFTER = 0.7
"""Seconds that the arm takes to answer a request to cancel."""
LIMIT = 3.0
"""Seconds within which the task wants the arm to arrive."""
ENDS_WITHIN = 8.0
"""Seconds that the program may run after its node appeared; a correct one needs at most half of them."""


class Robot:
    """The robot that the program under test talks to: its battery, its arm, and what was asked of them."""

    def __init__(self, percentage: float, arm: Arm) -> None:
        self.percentage = percentage
        self._arm = arm
        self.seen: list[str] = []
        """'battery' and 'goal', in the order in which the program asked."""
        self._asked = asyncio.Event()

    async def serve(self, node: goalwire.Node, late: float = 0.0) -> None:
        """Offer the service after `late` s, and the action `late` s after the first battery request."""
        from humanoid_interfaces.action import MoveArm
        from humanoid_interfaces.srv import GetBatteryStatus

        await asyncio.sleep(late)
        node.service(GetBatteryStatus, SERVICE, self._tell)
        if late:
            with suppress(TimeoutError):
                async with asyncio.timeout(ASKS_WITHIN):
                    await self._asked.wait()
            await asyncio.sleep(late)
        if isinstance(self._arm, Reluctant):
            self._arm.serve(node)
        else:
            node.action_server(MoveArm, ACTION, self._arm, accept=self._accept)

    def _tell(self, _request: GetBatteryStatus.Request) -> GetBatteryStatus.Response:
        from humanoid_interfaces.srv import GetBatteryStatus
        from sensor_msgs.msg import BatteryState

        self.seen.append('battery')
        self._asked.set()
        return GetBatteryStatus.Response(battery=BatteryState(percentage=self.percentage, present=True))

    def _accept(self, _goal: MoveArm.Goal) -> bool:
        self.seen.append('goal')
        return True


class Reluctant:
    """An arm that refuses its goal, or accepts it and never arrives. It records every later request.

    The five parts of the action are served one by one, because an action server would answer by itself.
    """

    def __init__(self, *, accepts: bool) -> None:
        self._accepts = accepts
        self.asked_for_result = False
        self.asked_to_cancel = False
        self.answered_cancel = False

    def serve(self, node: goalwire.Node) -> None:
        """Offer the three services and the two topics of the action."""
        from action_msgs.msg import GoalStatusArray
        from action_msgs.srv import CancelGoal
        from humanoid_interfaces.action import MoveArm

        parts, types = ActionNames(ACTION), MoveArm.Impl
        node.publisher(types.FeedbackMessage, parts.feedback)
        node.publisher(GoalStatusArray, parts.status, qos=ACTION_STATUS_DEFAULT)
        node.service(CancelGoal, parts.cancel_goal, self._cancel)
        node.service(types.GetResultService, parts.get_result, self._finish)
        node.service(types.SendGoalService, parts.send_goal, self._begin)

    def _begin(self, _request: Any) -> Any:
        from humanoid_interfaces.action import MoveArm

        return MoveArm.Impl.SendGoalService.Response(accepted=self._accepts)

    async def _finish(self, _request: Any) -> Any:
        """Answer a request for an unknown goal as ROS 2 does; never answer for an accepted goal."""
        from humanoid_interfaces.action import MoveArm

        self.asked_for_result = True
        if self._accepts:
            await asyncio.Event().wait()
        return MoveArm.Impl.GetResultService.Response()

    async def _cancel(self, request: CancelGoal.Request) -> CancelGoal.Response:
        from action_msgs.srv import CancelGoal

        self.asked_to_cancel = True
        await asyncio.sleep(CANCELS_AFTER)
        self.answered_cancel = True
        return CancelGoal.Response(goals_canceling=[request.goal_info])


async def steps(file: Path) -> AsyncIterator[str]:
    """Yield a sentence for each step that the program passes; raise Wrong at the first mistake."""
    async with _mission(file, Robot(0.8, _arrive), late=LATE) as (robot, student):
        code = await student.wait(ENDS_WITHIN, lambda: _explain_hang(robot.seen))
        _judge_order(robot)
        if code != 0:
            raise Wrong(
                f'all went well, but the exit code is {code}', f'it should be 0\n{student.last_lines()}'
            )
        yield 'it asks for the battery, moves the arm, and ends with exit code 0'
        if '50%' not in student.output.replace(' ', ''):
            raise Wrong(
                'the arm said that it was half way, and the program did not show it',
                "give send_goal_async a feedback_callback that prints fraction_done in percent: 0.5 as '50%'",
            )
        yield 'it shows the feedback in percent'
    async with _mission(file, Robot(0.1, _arrive)) as (robot, student):
        case = 'the battery is at 10 %'
        code = await _end(student, case)
        if 'goal' in robot.seen:
            raise Wrong(
                'the arm was moved although the battery is at 10 %',
                f'send no goal below {LEAST_CHARGE:.0%}: percentage < {LEAST_CHARGE}',
            )
        _judge_failure(code, case)
        yield 'it does not move the arm if the battery is low, and its exit code says so'
    refusing = Reluctant(accepts=False)
    async with _mission(file, Robot(0.8, refusing)) as (_, student):
        await _insist_on_failure(student, 'the arm refuses the goal')
        if refusing.asked_for_result:
            raise Wrong(
                'the arm refuses the goal, and the program asks for its result',
                'look at goal_handle.accepted before get_result_async(): a refused goal has no result',
            )
        yield 'its exit code says that the goal was refused'
    async with _mission(file, Robot(0.8, _fail)) as (_, student):
        await _insist_on_failure(student, 'the arm gets stuck, and the goal ends ABORTED')
        yield 'its exit code says that the goal failed'
    hanging = Reluctant(accepts=True)
    async with _mission(file, Robot(0.8, hanging)) as (_, student):
        await _insist_on_failure(student, 'the arm does not arrive')
        if not hanging.asked_to_cancel:
            raise Wrong(
                f'the program gave up after {LIMIT:g} s, and the arm still moves',
                'cancel the goal: goal_handle.cancel_goal_async(), and wait for the answer',
            )
        if not hanging.answered_cancel:
            raise Wrong(
                'the program asked to cancel the goal, and ended before the arm had answered',
                'cancel_goal_async() gives a future: wait for it, or the request may never leave',
            )
        yield f'it cancels a goal that takes longer than {LIMIT:g} s'


@asynccontextmanager
async def _mission(file: Path, robot: Robot, *, late: float = 0.0) -> AsyncIterator[tuple[Robot, Student]]:
    """Run the program beside a robot whose servers start later than the program."""
    async with alone() as node, Student(file) as student:
        await wait_for_node(node, student)
        serving = asyncio.create_task(robot.serve(node, late))
        try:
            yield robot, student
        finally:
            serving.cancel()
            await asyncio.wait({serving})


def _explain_hang(seen: list[str]) -> str:
    """Return the step at which a program hangs, and the likely cause."""
    late = 'it waits for an answer to {} that was sent before the {} was there: wait for it with {}, '
    limit = 'and look at what that returns: False if a timeout_sec is over'
    if 'battery' not in seen:
        return late.format('a request', 'service', 'wait_for_service()') + limit
    if 'goal' not in seen:
        return late.format('a goal', 'action server', 'wait_for_server()') + limit
    return 'it has to end by itself: wait for the result with spin_until_future_complete, not spin'


def _judge_order(robot: Robot) -> None:
    seen = robot.seen
    if 'battery' not in seen:
        raise Wrong(
            'the program ended without asking for the battery',
            f'call {SERVICE!r} first; wait_for_service() waits until it is there',
        )
    if 'goal' not in seen:
        raise Wrong(
            f'the battery was at {robot.percentage:.0%}, and the program sent no goal',
            f'send one to {ACTION!r}; percentage goes from 0 to 1, so compare with {LEAST_CHARGE}',
        )
    if seen[0] != 'battery':
        raise Wrong(
            'the goal was sent before the battery was known', 'wait for the answer of the service first'
        )
    if seen.count('goal') > 1:
        raise Wrong(f'{seen.count("goal")} goals were sent', 'one is enough')


async def _insist_on_failure(student: Student, case: str) -> None:
    _judge_failure(await _end(student, case), case)


async def _end(student: Student, case: str) -> int:
    return await student.wait(ENDS_WITHIN, lambda: f'it has to end by itself if {case}')


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
