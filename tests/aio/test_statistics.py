"""The statistics that each entity of a node counts."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TypeAlias

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import Play
from std_msgs.msg import String
from std_srvs.srv import SetBool

import goalwire
from goalwire.errors import CallError, DeadlineError, GoalAborted, GoalRefused, ServerFailedError

Taken: TypeAlias = goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]
IN_TIME = 5.0


def test_topics_count_what_goes_and_comes(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            subscription = node.subscription(String, 'topic', qos=2)
            witness = node.subscription(String, 'topic')
            publisher = node.publisher(String, 'topic')
            await publisher.wait_for_subscribers(2, timeout=IN_TIME)
            first = asyncio.ensure_future(anext(subscription))
            await asyncio.sleep(0)
            publisher.publish(data='first')
            assert (await first).data == 'first'
            for _ in range(3):
                publisher.publish(data='more')
            assert publisher.statistics().published == 4
            for _ in range(4):
                await anext(witness)
            counted = subscription.statistics()
            assert (counted.name, counted.taken, counted.waiting, counted.dropped) == ('/topic', 1, 2, 1)

    play(scenario)


def test_services_count_calls_and_what_came_of_them(play: Play) -> None:
    async def answer(request: SetBool.Request) -> SetBool.Response:
        if not request.data:
            raise KeyError('lamp')
        return SetBool.Response(success=True)

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            service = node.service(SetBool, 'lamp', answer)
            client = node.client(SetBool, 'lamp')
            for data in (True, True, False):
                with suppress(ServerFailedError, DeadlineError):  # DDS cannot tell of the failure
                    await client.call(data=data, timeout=1.0)
            asked, served = client.statistics(), service.statistics()
            assert (asked.name, asked.sent, asked.answered, asked.in_flight) == ('/lamp', 3, 2, 0)
            assert asked.unanswered + asked.given_up == 1
            assert (served.received, served.answered, served.failed) == (3, 2, 1)
            assert (served.in_flight, served.waiting, served.refused, served.rejected) == (0, 0, 0, 0)
            for histogram in (asked.latency, served.latency):
                assert histogram.count == 2
                assert 0 <= histogram.p50 <= histogram.p99 < IN_TIME

    play(scenario)


def test_calls_in_flight_are_counted_and_those_given_up(play: Play) -> None:
    async def scenario() -> None:
        began = asyncio.Event()

        async def hang(_: SetBool.Request) -> SetBool.Response:
            began.set()
            await asyncio.Event().wait()
            return SetBool.Response()

        async with goalwire.Node('node') as node:
            service = node.service(SetBool, 'lamp', hang)
            client = node.client(SetBool, 'lamp')
            calling = asyncio.ensure_future(client.call())
            await began.wait()
            assert client.statistics().in_flight == service.statistics().in_flight == 1
            calling.cancel()
            with suppress(asyncio.CancelledError):
                await calling
            asked = client.statistics()
            assert (asked.in_flight, asked.given_up, asked.answered) == (0, 1, 0)

    play(scenario)


def test_actions_count_goals_by_their_ends(play: Play) -> None:
    async def work(goal: Taken) -> Fibonacci.Result:
        goal.feedback(sequence=[1])
        if goal.request.order == 1:
            raise KeyError('joint')
        if goal.request.order == 2:
            await asyncio.Event().wait()
        return Fibonacci.Result()

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            server = node.action_server(Fibonacci, 'job', work, accept=lambda goal: goal.order < 3)
            client = node.action(Fibonacci, 'job')
            await client.call(order=0, timeout=IN_TIME)
            for order, error in ((1, GoalAborted), (3, GoalRefused)):
                with pytest.raises(error):
                    await client.call(order=order, timeout=IN_TIME)
            async with client.send(order=2, timeout=IN_TIME) as run:
                await anext(run.feedback)
                assert server.statistics().goals.running == client.statistics().goals.active == 1
                await run.cancel(timeout=IN_TIME)
                with suppress(CallError):
                    await run.result
            sent, served = client.statistics(), server.statistics()
            assert (sent.name, sent.goals.sent) == (served.name, 4) == ('/job', 4)
            for goals in (sent.goals, served.goals):
                assert (goals.accepted, goals.refused) == (3, 1)
                assert (goals.succeeded, goals.canceled, goals.aborted) == (1, 1, 1)
            assert (sent.feedback, sent.feedback_dropped, served.feedback, served.failed) == (3, 0, 3, 1)
            assert sent.acceptance.count == 4
            assert sent.duration.count == served.execution.count == 3

    play(scenario)


def test_a_timer_counts_ticks_what_it_missed_and_how_late_it_was(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            timer = node.timer(0.01)
            await anext(timer)
            assert timer.statistics().calls >= 1
            deadline = asyncio.get_running_loop().time() + 0.05
            while asyncio.get_running_loop().time() < deadline:
                pass  # the loop is held up
            await anext(timer)
            await anext(timer)
            counted = timer.statistics()
            assert counted.period == 0.01
            assert counted.missed >= 3
            assert counted.lateness.count == counted.calls
            assert counted.lateness.quantile(1.0) > 0.01

    play(scenario)


def test_a_node_shows_what_everything_in_it_counts(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            publisher = node.publisher(String, 'topic')
            node.subscription(String, 'topic')
            node.client(SetBool, 'lamp')
            node.action(Fibonacci, 'job')
            node.action_server(Fibonacci, 'job', lambda _: asyncio.sleep(0, Fibonacci.Result()))
            node.timer(1.0)
            publisher.publish(data='one')
            counted = node.statistics()
            assert counted.name == '/node'
            assert publisher.statistics() in counted.publishers
            assert '/topic' in [each.name for each in counted.subscriptions]
            assert [each.name for each in counted.clients] == ['/lamp']
            assert '/node/get_parameters' in [each.name for each in counted.services]
            assert [each.name for each in counted.action_clients] == ['/job']
            assert [each.name for each in counted.action_servers] == ['/job']
            assert [each.period for each in counted.timers] == [1.0]

    play(scenario)
