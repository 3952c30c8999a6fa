"""The types of rclpy's front, as mypy --strict sees them in a program."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest
from helpers.type_checking import editor_remarks, type_errors

from goalwire.idl import hook, search_path
from goalwire.idl.workspace import KINDS


@pytest.mark.slow
def test_entities_are_tied_to_their_interfaces(tmp_path: Path) -> None:
    program = """\
        from typing import Any, TypeAlias, assert_type
        from example_interfaces.action import Fibonacci
        from rclpy.action import ActionClient, ActionServer
        from rclpy.action.client import ClientGoalHandle, FeedbackMessage, ResultResponse
        from rclpy.action.server import ServerGoalHandle
        from rclpy.client import Client
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.experimental import AsyncNode, AsyncPublisher
        from rclpy.node import Node
        from rclpy.publisher import Publisher
        from rclpy.service import Service
        from rclpy.subscription import Subscription
        from rclpy.task import Future, Task
        from std_msgs.msg import String
        from std_srvs.srv import SetBool, Trigger

        Sent: TypeAlias = ClientGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]
        Taken: TypeAlias = ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]

        async def talk_in_a_loop() -> None:
            async with AsyncNode('a') as node:
                assert_type(node.create_publisher(String, 'a', 1), AsyncPublisher[String])
                client = node.create_client(SetBool, 'b')
                assert_type(await client.call(SetBool.Request()), SetBool.Response)

        def talk(node: Node) -> None:
            assert_type(node.create_publisher(String, 'a', 1), Publisher[String])
            assert_type(node.create_subscription(String, 'a', print, 1), Subscription[String])
            client = node.create_client(SetBool, 'b')
            assert_type(client, Client[SetBool.Request, SetBool.Response])
            assert_type(client.call_async(SetBool.Request()), Future[SetBool.Response])
            assert_type(client.call(SetBool.Request()), SetBool.Response | Any)
            service = node.create_service(SetBool, 'b', lambda request, response: answer(request, response))
            assert_type(service, Service[SetBool.Request, SetBool.Response])
            node.create_service(SetBool, 'c', answer_later)

        def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
            return SetBool.Response(success=request.data)

        async def answer_later(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
            return response

        def act(node: Node) -> None:
            client = ActionClient(node, Fibonacci, 'fib')
            assert_type(client, ActionClient[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback])
            sent = client.send_goal_async(Fibonacci.Goal(order=1), hear)
            assert_type(sent.result(), Sent | Any)
            sent = client.send_goal_async(Fibonacci.Goal(order=1), feedback_callback=hear_ours)
            handle: Sent = sent.result()
            assert_type(handle.accepted, bool)
            assert_type(handle.get_result_async(), Future[ResultResponse[Fibonacci.Result]])
            answer = handle.get_result()
            assert answer is not None
            assert_type(answer.result, Fibonacci.Result)
            ActionServer(node, Fibonacci, 'fib', execute)
            ActionServer(node, Fibonacci, 'fib', execute_later)

        def hear(message: FeedbackMessage[Fibonacci.Feedback]) -> None:
            assert_type(message.feedback, Fibonacci.Feedback)

        def hear_ours(message: Fibonacci.Impl.FeedbackMessage) -> None: ...

        def execute(handle: Taken) -> Fibonacci.Result:
            assert_type(handle.request, Fibonacci.Goal)
            handle.publish_feedback(Fibonacci.Feedback())
            return Fibonacci.Result()

        async def execute_later(handle: ServerGoalHandle) -> Fibonacci.Result:
            return Fibonacci.Result()

        async def number(text: str) -> int:
            return int(text)

        def tasks(executor: SingleThreadedExecutor) -> None:
            assert_type(executor.create_task(number, '1'), Task[int])
            assert_type(executor.create_task(number('1')), Task[int])
            assert_type(executor.create_task(len, 'ab'), Task[int])
            assert_type(executor.create_task(len, 'ab').result(), int | Any)

        def mistakes(node: Node, handle: Taken) -> None:
            handle.publish_feedback(Fibonacci.Result())
            node.create_publisher(String, 'a', 1).publish(SetBool.Request())
            node.create_client(SetBool, 'b').call_async(Trigger.Request())
            node.create_client(String, 'b')
            node.create_service(Trigger, 'b', answer)
            client = ActionClient(node, Fibonacci, 'fib')
            client.send_goal_async(Fibonacci.Result())
            client.send_goal_async(Fibonacci.Goal(), lambda message: print(message.feedbak))
            ActionServer(node, Fibonacci, 'fib', lambda handle: Fibonacci.Goal())
    """
    lines = textwrap.dedent(program).splitlines()
    errors = dict.fromkeys(lines[int(line) - 1].strip() for line, _ in type_errors(program, tmp_path))
    mistakes = lines[lines.index('def mistakes(node: Node, handle: Taken) -> None:') + 1 :]
    assert list(errors) == [line.strip() for line in mistakes if "(node, Fibonacci, 'fib')" not in line]


LAMBDAS = """\
    from typing import assert_type
    from rclpy.experimental import AsyncNode
    from rclpy.node import Node
    from std_msgs.msg import String

    def listen(node: Node, other: AsyncNode) -> None:
        node.create_subscription(String, 'a', lambda message: print(message.data.upper()), 10)
        node.create_subscription(String, 'a', lambda message, info: print(info['source_timestamp'] + 1), 10)
        node.create_subscription(String, 'a', lambda data: print(data.hex()), 10, raw=True)
        other.create_subscription(String, 'a', lambda message: print(message.data.upper()), 10)
        node.create_subscription(String, 'a', lambda message: print(message.date), 10)
        other.create_subscription(String, 'a', lambda message: print(message.date), 10)
    """


@pytest.mark.slow
def test_an_editor_finds_all_packages_and_what_a_lambda_gets(tmp_path: Path) -> None:
    assert editor_remarks(LAMBDAS, tmp_path) == [
        (11, 'reportAttributeAccessIssue'), (12, 'reportAttributeAccessIssue')
    ]  # fmt: skip
    shipped = sorted(folder.name for folder in Path(search_path.SHIPPED).iterdir())
    kinds = {
        name: [kind for kind in KINDS if Path(search_path.SHIPPED, name, kind).is_dir()] for name in shipped
    }
    companions = [
        folder.name for folder in Path(hook.OVERLAY).iterdir() if (folder / '__init__.py').is_file()
    ]
    assert [name for name in companions if not (Path(hook.OVERLAY) / name / 'py.typed').is_file()] == []
    modules = [f'{name}.{kind}' for name in shipped for kind in kinds[name]] + companions
    assert len(modules) > 40
    assert editor_remarks(''.join(f'import {module}\n' for module in modules), tmp_path) == []
