"""How action goals begin and end.

A control tick decides how a goal ends; the goal's execute callback carries the decision out. An error ends
only its own goal: the goal is refused, or aborted with the reason, and the server runs on.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from typing import Protocol, TypeVar

import numpy  # noqa: F401, ICN001 - the id of a goal is its array: to import it must not hold up a motion
from rclpy.action import GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future

from humanoid.running import log_failure
from humanoid.text import brief


class End(Enum):
    SUCCEEDED = 'succeeded'
    CANCELED = 'canceled'
    ABORTED = 'aborted'


@dataclass(frozen=True)
class Ending:
    end: End
    message: str

    @property
    def success(self) -> bool:
        return self.end is End.SUCCEEDED


class Decision:
    """The ending of one goal: a tick decides it, and the goal's coroutine waits for it."""

    def __init__(self) -> None:
        self._future: Future[Ending] = Future()

    @property
    def made(self) -> bool:
        return self._future.done()

    def make(self, ending: Ending) -> None:
        self._future.set_result(ending)

    async def wait(self) -> Ending:
        ending = await self._future
        assert ending is not None  # for the type checker: rclpy's Future may hold None
        return ending


class Decided(Protocol):
    """A running goal in its server's table: any object with a Decision."""

    @property
    def decision(self) -> Decision: ...


D = TypeVar('D', bound=Decided)


def judge(node: Node, check: Callable[[], str | None]) -> GoalResponse:
    """Return REJECT and log why if `check` returns a reason or raises an exception; else return ACCEPT."""
    try:
        reason = check()
    except Exception as error:
        log_failure(node, error)
        return GoalResponse.REJECT
    if reason is None:
        return GoalResponse.ACCEPT
    node.get_logger().warning(f'Rejected: {brief(reason)}')
    return GoalResponse.REJECT


class GoalFailed(Exception):
    """A goal cannot go on, but the server has no fault. The text becomes the message of the result."""


@contextmanager
def or_abort(node: Node, end: Callable[[Ending], None]) -> Generator[None, None, None]:
    """If the block raises, call `end` to abort the goal, with the reason as its message."""
    try:
        yield
    except GoalFailed as reason:
        end(Ending(End.ABORTED, str(reason)))
    except Exception as error:
        log_failure(node, error)
        end(Ending(End.ABORTED, brief(f'the server failed: {type(error).__name__}: {error}')))


def settle(goal_handle: ServerGoalHandle, ending: Ending) -> None:
    """Put the goal into the terminal state that was decided."""
    if ending.end is End.SUCCEEDED:
        goal_handle.succeed()
    elif ending.end is End.CANCELED:
        goal_handle.canceled()
    else:
        goal_handle.abort()


async def carry_out(node: Node, goal_handle: ServerGoalHandle, goals: dict[bytes, D]) -> tuple[D, Ending]:
    """Wait until a tick decides how a goal ends; end it that way and remove it from `goals`."""
    key = bytes(goal_handle.goal_id.uuid)
    goal = goals[key]
    try:
        ending = await goal.decision.wait()
    finally:
        del goals[key]
    settle(goal_handle, ending)
    node.get_logger().info(ending.message)
    return goal, ending
