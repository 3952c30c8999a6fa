"""Sends the recorded requests and goals to live servers, and compares the answers with the recording.

A request is sent at its recorded time, but only after all calls and goals have ended that had ended before it
in the recording. So even a slow server gets the requests in the recorded order.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from goalwire.aio import Node
from goalwire.aio.action.client import Run
from goalwire.apps.bag.message_comparison import Difference, Tolerance, compare
from goalwire.apps.bag.recorded_requests import Recorded, RecordedCall, RecordedGoal, read_recorded
from goalwire.apps.bag.selection import Selection
from goalwire.errors import BagError, CallError, GoalCanceled, GoalFailed, GoalRefused
from goalwire.idl import get_action, get_service
from goalwire.records import record
from goalwire.rosbag2.reader import Reader
from goalwire.rules.goals.states import GoalStatus

_S = 1_000_000_000
SHOWN_REQUEST = 80
"""The most characters of a request in the text of a difference."""


@record
class ReplayOptions:
    """The settings for sending recorded requests and goals."""

    selection: Selection | None = None
    """The services and actions to send to; None: all."""
    tolerance: Tolerance = Tolerance()
    rate: float = 1.0
    """The speed, as a multiple of the recorded one. Infinity waits only for earlier answers."""
    timeout: float = 10.0
    """Seconds that an answer may take, and that a goal may take longer than recorded."""


class Replay:
    """`differences = await Replay(node, bag).run()`: an empty list if the servers answer as recorded."""

    def __init__(self, node: Node, bag: Reader, options: ReplayOptions | None = None) -> None:
        """Make the clients for the recorded calls and goals.

        Raises BagError if the bag has nothing to send, InterfaceError for types that are unknown here.
        """
        self.options = options or ReplayOptions()
        self.recorded: Sequence[Recorded] = read_recorded(bag, self.options.selection)
        if not self.recorded:
            raise BagError(
                f"'{bag.path}' has no calls or goals for the chosen names: record them with --services"
            )
        self._clients: dict[str, Any] = {}
        for each in self.recorded:
            if each.name not in self._clients:
                if isinstance(each, RecordedGoal):
                    self._clients[each.name] = node.action(get_action(each.type_name), each.name)
                else:
                    self._clients[each.name] = node.client(get_service(each.type_name), each.name)
        self.calls = sum(isinstance(each, RecordedCall) for each in self.recorded)
        """The number of requests that are sent."""
        self.goals = len(self.recorded) - self.calls
        """The number of goals that are sent."""

    async def run(self) -> list[Difference]:
        """Send everything, wait for all answers, and return the differences in the order of the recording."""
        loop = asyncio.get_running_loop()
        start, first = loop.time(), self.recorded[0].sent
        tasks: list[asyncio.Task[list[Difference]]] = []
        async with asyncio.TaskGroup() as group:
            for number, each in enumerate(self.recorded, 1):
                await asyncio.sleep(start + (each.sent - first) / _S / self.options.rate - loop.time())
                before = [
                    task
                    for task, other in zip(tasks, self.recorded, strict=False)
                    if other.ended and other.ended <= each.sent
                ]
                if before:
                    await asyncio.wait(before)
                tasks.append(group.create_task(self._replay(each, number)))
        return [difference for task in tasks for difference in task.result()]

    async def _replay(self, each: Recorded, number: int) -> list[Difference]:
        request = each.goal if isinstance(each, RecordedGoal) else each.request
        what = 'goal' if isinstance(each, RecordedGoal) else 'call'
        where = f"{what} {number} '{each.name}' {_show(request)}"
        try:
            if isinstance(each, RecordedGoal):
                return await self._send(each, where)
            return await self._call(each, where)
        except CallError as error:
            return [Difference(where, 'the answer', f'{type(error).__name__} ({error})', 'there')]

    async def _call(self, call: RecordedCall, where: str) -> list[Difference]:
        response = await self._clients[call.name].call(call.request, timeout=self.options.timeout)
        if call.response is None:
            return []
        return compare(where, response, call.response, self.options.tolerance)

    async def _send(self, goal: RecordedGoal, where: str) -> list[Difference]:
        """Send a goal, cancel it if it was cancelled in the recording, and compare its end."""
        lasted = max(goal.ended - goal.sent, 0) / _S
        run = self._clients[goal.name].send(goal.goal, timeout=lasted + self.options.timeout)
        try:
            async with run:
                live = LiveGoal(run)
                await live.follow(goal)
        except GoalRefused:
            return _difference(where, 'accepted', now=False, was=goal.is_accepted)
        return self._compare_goal(goal, live, where)

    def _compare_goal(self, goal: RecordedGoal, live: LiveGoal, where: str) -> list[Difference]:
        tolerance = self.options.tolerance
        found = _difference(where, 'accepted', now=True, was=goal.is_accepted)
        if not goal.ended or found:
            return found
        if live.status != goal.status:
            was = GoalStatus(goal.status).name
            found.append(Difference(where, 'status', GoalStatus(live.status).name, was))
        recorded = len(goal.feedback)
        if abs(live.feedback - recorded) > tolerance.feedback:
            found.append(
                Difference(
                    where, 'feedback', f'{live.feedback} times', f'{recorded} times', tolerance.feedback
                )
            )
        return found + compare(where, live.result, goal.result, tolerance, 'result')


class LiveGoal:
    """A recorded goal that was sent again, and its outcome."""

    def __init__(self, run: Run[Any, Any]) -> None:
        self._run = run
        self.feedback = 0
        """How many feedback messages came."""
        self.status = GoalStatus.UNKNOWN
        self.result: Any = None

    async def follow(self, goal: RecordedGoal) -> None:
        """Wait until the goal ends; cancel it after as many feedback messages as in the recording.

        A goal that was cancelled before any feedback is cancelled at the recorded time. Raises CallError if
        the goal does not end.
        """
        accepted = asyncio.get_running_loop().time()
        cancels = sorted(goal.cancels)
        counting = asyncio.create_task(self._count([goal.feedback_before(at) for at in cancels]))
        try:
            for at in cancels:
                if not goal.feedback_before(at):
                    late = (at - (goal.answered or goal.sent)) / _S
                    await asyncio.sleep(accepted + late - asyncio.get_running_loop().time())
                    await self._cancel()
            self.result = await self._run.result
            self.status = GoalStatus.SUCCEEDED
        except GoalFailed as failed:
            self.result = failed.result
            self.status = GoalStatus.CANCELED if isinstance(failed, GoalCanceled) else GoalStatus.ABORTED
        except BaseException:
            counting.cancel()
            raise
        await counting  # The stream of feedback ends when the goal ends.

    async def _count(self, cancel_after: list[int]) -> None:
        async for _ in self._run.feedback:
            self.feedback += 1
            if self.feedback in cancel_after:
                await self._cancel()

    async def _cancel(self) -> None:
        with suppress(CallError):  # The goal has ended already; the comparison will report how.
            await self._run.cancel()


def _difference(where: str, field: str, *, now: bool, was: bool | None) -> list[Difference]:
    return [] if was in {None, now} else [Difference(where, field, str(now), str(was))]


def _show(message: Any) -> str:
    fields = ', '.join(f'{name}={getattr(message, name)!r}' for name in message.get_fields_and_field_types())
    return f'({fields if len(fields) <= SHOWN_REQUEST else fields[:SHOWN_REQUEST] + "…"})'
