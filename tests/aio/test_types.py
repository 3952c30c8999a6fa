"""The types of the asyncio API, as mypy --strict sees them in a program."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest
from helpers.type_checking import type_errors


@pytest.mark.slow
def test_what_a_node_makes_is_tied_to_its_interfaces(tmp_path: Path) -> None:
    program = """\
        from collections.abc import AsyncIterator
        from typing import assert_type
        from example_interfaces.action import Fibonacci
        from std_msgs.msg import String
        from std_srvs.srv import SetBool, Trigger
        import goalwire

        async def switch(request: SetBool.Request) -> SetBool.Response:
            return SetBool.Response(success=request.data)

        async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
            assert_type(goal.request, Fibonacci.Goal)
            goal.feedback(Fibonacci.Feedback())
            goal.feedback(sequence=[1])
            return Fibonacci.Result()

        async def main() -> None:
            async with goalwire.Node('node') as node:
                assert_type(node, goalwire.Node)
                assert_type(node.publisher(String, 'chat'), goalwire.Publisher[String])
                async for message in node.subscription(String, 'chat', qos=goalwire.QoS(depth=1)):
                    assert_type(message, String)
                client = node.client(SetBool, 'switch')
                assert_type(client, goalwire.Client[SetBool.Request, SetBool.Response])
                assert_type(await client.call(data=True, timeout=1.0), SetBool.Response)
                node.service(SetBool, 'switch', switch)
                node.service(SetBool, 'plain', lambda request: SetBool.Response(success=request.data))
                assert_type(node.parameters.declare('speed', 1.0), float)
                move = node.action(Fibonacci, 'count')
                async with move.send(Fibonacci.Goal(order=3), timeout=1.0) as run:
                    async for feedback in run.feedback:
                        assert_type(feedback, Fibonacci.Feedback)
                    assert_type(await run.result, Fibonacci.Result)
                assert_type(await move.call(order=3), Fibonacci.Result)
                node.action_server(Fibonacci, 'count', count, accept=lambda goal: goal.order > 0)

        async def wrong(node: goalwire.Node) -> None:
            await node.client(SetBool, 'switch').call(Trigger.Request())
            node.service(Trigger, 'switch', switch)
            node.publisher(String, 'chat').publish('text')
            node.action(Fibonacci, 'count').send(Fibonacci.Result())
            node.action_server(Fibonacci, 'count', switch)
    """
    lines = textwrap.dedent(program).splitlines()
    first = lines.index('async def wrong(node: goalwire.Node) -> None:') + 2
    errors = type_errors(program, tmp_path)
    assert [line for line, _ in errors] == [str(first + offset) for offset in range(5)]
    assert {code for _, code in errors} == {'arg-type'}
