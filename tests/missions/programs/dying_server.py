"""Serves the action `job` with a journal, notes executions in a file, and kills itself at BOUNDARY, if given.

`dying_server.py JOURNAL EXECUTIONS asyncio|rclpy [BOUNDARY]`
"""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle

import goalwire
from goalwire.entities.actions.journal_file import JournalFile
from goalwire.entities.actions.server_decisions import ServerDecisions
from goalwire.entities.actions.server_results import ServerResults

JOURNAL, EXECUTIONS, FACE, BOUNDARY = [*sys.argv[1:], ''][:4]


def die() -> NoReturn:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError('a killed process does nothing more')


def reach(boundary: str) -> None:
    """Note what happens, and die at the chosen place."""
    if boundary == 'executing':
        with Path(EXECUTIONS).open('a', encoding='utf-8') as executions:
            print('executed', file=executions)
    if boundary and boundary == BOUNDARY:
        die()


def around(cls: type, method: str, before: str, after: str) -> None:
    """Have a method reach a boundary before it and another one after it."""
    real: Callable[..., Any] = getattr(cls, method)

    def watched(self: object, *arguments: Any) -> Any:
        reach(before)
        outcome = real(self, *arguments)
        reach(after)
        return outcome

    setattr(cls, method, watched)


async def serve_asyncio() -> None:
    async def job(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        reach('executing')
        return Fibonacci.Result(sequence=[goal.request.order])

    async with goalwire.Node('server') as node:
        node.action_server(Fibonacci, 'job', job, journal=JOURNAL)
        print('ready', flush=True)
        await asyncio.Event().wait()


def serve_rclpy() -> None:
    def job(
        goal: ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback],
    ) -> Fibonacci.Result:
        reach('executing')
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order])

    with rclpy.init():
        node = rclpy.create_node('server')
        ActionServer(node, Fibonacci, 'job', job, journal=JOURNAL)
        print('ready', flush=True)
        rclpy.spin(node)


around(JournalFile, '_begin', 'before its beginning is written', '')
around(ServerDecisions, '_settle', 'after its beginning is written', 'after it is accepted')
around(JournalFile, '_end', 'before its end is written', '')
around(ServerResults, '_answer_all', 'after its end is written', 'after its result is sent')
if FACE == 'asyncio':
    asyncio.run(serve_asyncio())
else:
    serve_rclpy()
