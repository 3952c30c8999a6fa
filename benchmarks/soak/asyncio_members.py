"""A server and a client of the asyncio API."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from random import Random

from example_interfaces.action import Fibonacci
from example_interfaces.msg import Int64
from example_interfaces.srv import AddTwoInts

import goalwire
from benchmarks.soak.obedience import Obedience
from benchmarks.soak.report import Call, Hearing, Report
from benchmarks.soak.work import (
    ABORT,
    DAWDLE,
    DAWDLE_S,
    FAIL,
    GIVEN_UP,
    GRACE_S,
    MORTAL,
    REFUSE,
    STEADY,
    STEP_S,
    Work,
    choose,
)


async def serve(name: str, report: Report, stop: asyncio.Event) -> None:
    """Serve `<name>/add` and `<name>/count`, publish `<name>/tick`, until told to stop."""

    async def add(request: AddTwoInts.Request) -> AddTwoInts.Response:
        report.handled(request.a)
        if request.b == FAIL:
            raise ValueError('asked to fail')
        if request.b == DAWDLE:
            await asyncio.sleep(DAWDLE_S)
        return AddTwoInts.Response(sum=request.a + request.b)

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        report.handled(goal.goal_id.hex())
        if goal.request.order == ABORT:
            raise goalwire.GoalAborted('asked to abort')
        sequence = []
        for step in range(goal.request.order):
            sequence.append(step)
            goal.feedback(sequence=sequence[-3:])
            await asyncio.sleep(STEP_S)
        return Fibonacci.Result(sequence=sequence)

    obedience = Obedience(report)

    def step(request: AddTwoInts.Request) -> AddTwoInts.Response:
        obedience.hear('call', request.a)
        return AddTwoInts.Response()

    async def walk(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        obedience.hear('goal', goal.request.order)
        return Fibonacci.Result()

    async with goalwire.Node(f'{name}_server') as node:
        node.service(AddTwoInts, f'{name}/step', step)
        node.action_server(Fibonacci, f'{name}/walk', walk)
        node.service(AddTwoInts, f'{name}/add', add)
        node.action_server(Fibonacci, f'{name}/count', count, accept=lambda goal: goal.order != REFUSE)
        tick = node.publisher(Int64, f'{name}/tick')
        timer = node.timer(0.1)
        telling = asyncio.ensure_future(_tick(timer, tick, report))
        moves = node.subscription(Int64, f'{name}/move', qos=1000)
        obeying = asyncio.ensure_future(_obey(moves, obedience))
        report.say('ready')
        await stop.wait()
        telling.cancel()
        obeying.cancel()


async def _obey(moves: goalwire.Subscription[Int64], obedience: Obedience) -> None:
    async for message in moves:
        obedience.hear('message', message.data)


async def _tick(timer: goalwire.Timer, tick: goalwire.Publisher[Int64], report: Report) -> None:
    async for _ in timer:
        tick.publish(data=report.new_tag())


class Caller:
    """Calls all servers, `workers` calls at a time."""

    def __init__(self, node: goalwire.Node, report: Report, random: Random) -> None:
        self._node = node
        self._report = report
        self._random = random
        servers = (*STEADY, *MORTAL)
        self._services = {name: node.client(AddTwoInts, f'{name}/add') for name in (*servers, 'nobody')}
        self._actions = {name: node.action(Fibonacci, f'{name}/count') for name in servers}

    async def work(self, stop: asyncio.Event) -> None:
        while not stop.is_set():
            work, server = choose(self._random)
            if work.outcome == GIVEN_UP:
                await self._give_up(work, server)
            else:
                await self._ask(work, server)
            await asyncio.sleep(self._random.uniform(0, 0.2))

    async def _ask(self, work: Work, server: str) -> None:
        with self._report.call(work, server) as call:
            await (self._goal if work.is_goal else self._call)(work, server, call)

    async def _call(self, work: Work, server: str, call: Call) -> None:
        answer = await self._services[server].call(a=call.tag, b=work.ask, timeout=work.timeout)
        self._report.check_sum(work, call, answer.sum)

    async def _goal(self, work: Work, server: str, call: Call) -> None:
        run = self._actions[server].send(order=work.ask, timeout=work.timeout, grace=GRACE_S)
        call.handled_as = run.goal_id.hex()
        seen: list[int] = []
        async with run:
            async for feedback in run.feedback:
                seen.append(feedback.sequence[-1])
                if work.outcome == 'GoalCanceled' and len(seen) == 3:
                    await run.cancel(timeout=work.timeout)
            result = await run.result
        self._report.check_goal(work, result.sequence, seen)

    async def _give_up(self, work: Work, server: str) -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(self._random.uniform(0, 0.2)):
                await self._ask(work, server)

    async def listen(self, name: str, stop: asyncio.Event) -> None:
        hearing = Hearing(self._report)
        ticks = self._node.subscription(Int64, f'{name}/tick')
        ended = asyncio.ensure_future(stop.wait())
        ended.add_done_callback(lambda _: ticks.close())
        try:
            async for message in ticks:
                hearing.hear(message.data)
        finally:
            ended.cancel()
            hearing.tell()


async def call(name: str, report: Report, stop: asyncio.Event, workers: int = 6) -> None:
    """Call all servers and listen to them, until told to stop; then wait for what is under way."""
    async with goalwire.Node(f'{name}_client') as node:
        caller = Caller(node, report, Random())
        report.say('ready')
        async with asyncio.TaskGroup() as group:
            for _ in range(workers):
                group.create_task(caller.work(stop))
            for server in (*STEADY, *MORTAL):
                group.create_task(caller.listen(server, stop))
        report.check_empty(node.statistics())
