"""Servers that answer clients with the responses, feedback and results of a bag."""

from __future__ import annotations

import asyncio
from collections import defaultdict, deque
from collections.abc import Iterable
from functools import partial
from typing import Any

from goalwire.aio import Node
from goalwire.aio.action.server import Goal
from goalwire.apps.bag.recorded_requests import (
    Recorded,
    RecordedCall,
    RecordedGoal,
    content_of,
    read_recorded,
)
from goalwire.apps.bag.selection import Selection
from goalwire.errors import BagError, GoalAborted
from goalwire.idl import get_action, get_service
from goalwire.rosbag2.reader import Reader
from goalwire.rules.goals.states import GoalStatus

_S = 1_000_000_000


class Script:
    """The recordings of one service or action, in the order in which they are answered.

    A request with the content of a recorded request gets the recorded answer. If several recordings have this
    content, each is used once in their order, then the last one again and again. Any other request gets the
    next unused recording.
    """

    def __init__(self, recordings: Iterable[Recorded]) -> None:
        self._by_content: dict[bytes, deque[Recorded]] = defaultdict(deque)
        self._unused: dict[Recorded, None] = {}
        for each in recordings:
            self._by_content[content_of(_get_request(each))].append(each)
            self._unused[each] = None

    def take(self, request: Any) -> Any:
        """Return the recording that answers a request. Raises BagError if no recording is left."""
        equal = self._by_content.get(content_of(request))
        if equal:
            found = equal.popleft() if len(equal) > 1 else equal[0]
        elif self._unused:
            found = next(iter(self._unused))
        else:
            raise BagError(f'the bag has no answer to {request}, and no unused answer is left')
        self._unused.pop(found, None)
        return found


def _get_request(each: Recorded) -> Any:
    return each.goal if isinstance(each, RecordedGoal) else each.request


class Answers:
    """Serves the services and actions of a bag with a node's servers, which end with the node."""

    def __init__(
        self, node: Node, bag: Reader, selection: Selection | None = None, *, rate: float = 1.0
    ) -> None:
        """Declare the servers. An answer takes the recorded time, divided by `rate`.

        Raises BagError if the bag has no answers, InterfaceError for types that are unknown here.
        """
        by_name: dict[str, list[Recorded]] = defaultdict(list)
        for each in read_recorded(bag, selection):
            if isinstance(each, RecordedGoal) or each.response is not None:
                by_name[each.name].append(each)
        if not by_name:
            raise BagError(f"'{bag.path}' has no answers for the chosen names: record them with --services")
        self.names = tuple(by_name)
        """The services and actions to answer."""
        self.answered = 0
        """How many requests and goals were answered."""
        self._rate = rate
        self._waiting: dict[bytes, deque[RecordedGoal]] = defaultdict(deque)
        """Recordings for accepted goals that have not started, by the content of the goal."""
        for name, recordings in by_name.items():
            script = Script(recordings)
            type_name = recordings[0].type_name
            if isinstance(recordings[0], RecordedGoal):
                accept, run = partial(self._accept, script), self._run
                node.action_server(get_action(type_name), name, run, accept=accept)
            else:
                node.service(get_service(type_name), name, partial(self._answer, script))

    async def _answer(self, script: Script, request: Any) -> Any:
        call: RecordedCall = script.take(request)
        await self._pass(call.sent, call.ended)
        self.answered += 1
        return call.response

    def _accept(self, script: Script, request: Any) -> bool:
        goal: RecordedGoal = script.take(request)
        if goal.is_accepted is False:
            self.answered += 1
            return False
        self._waiting[content_of(request)].append(goal)
        return True

    async def _run(self, goal: Goal[Any, Any]) -> Any:
        recorded = self._waiting[content_of(goal.request)].popleft()
        now = recorded.answered or recorded.sent
        try:
            for time, feedback in recorded.feedback:
                await self._pass(now, time)
                goal.feedback(feedback)
                now = max(now, time)
            if not recorded.ended or recorded.status == GoalStatus.CANCELED:
                await asyncio.Event().wait()  # the goal runs until its client cancels it
            await self._pass(now, recorded.ended)
        except asyncio.CancelledError:
            if recorded.status != GoalStatus.CANCELED:
                raise
        self.answered += 1
        if recorded.status == GoalStatus.ABORTED:
            raise GoalAborted('the recorded goal was aborted, too', result=recorded.result)
        return recorded.result

    async def _pass(self, start: int, end: int) -> None:
        """Wait for the time between two recorded times in ns, divided by the rate."""
        await asyncio.sleep(max(end - start, 0) / _S / self._rate)
