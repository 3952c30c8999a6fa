"""How a goal ends: decided by a control tick, carried out by the goal's own execute callback."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future


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
    """The ending of one goal, awaited by the goal's coroutine."""

    def __init__(self) -> None:
        self._future: Future[Ending] = Future()

    @property
    def made(self) -> bool:
        return self._future.done()

    def make(self, ending: Ending) -> None:
        self._future.set_result(ending)

    async def wait(self) -> Ending:
        ending = await self._future
        assert ending is not None  # rclpy's futures may hold None; this one never does
        return ending


def settle(goal_handle: ServerGoalHandle, ending: Ending) -> None:
    """Put the goal into the terminal state that was decided."""
    if ending.end is End.SUCCEEDED:
        goal_handle.succeed()
    elif ending.end is End.CANCELED:
        goal_handle.canceled()
    else:
        goal_handle.abort()
