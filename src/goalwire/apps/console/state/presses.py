"""The presses of STOP. A press can come to the console in two ways and is done once. Its answers are kept."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Sequence
from typing import TypeAlias

from goalwire.apps.console.state.rights import Rights
from goalwire.apps.console.state.stopping import Answer, Listener
from goalwire.errors import GoalwireError, peer_text

MOST = 100
"""The number of presses that are remembered, with their answers."""
MOST_LETTERS = 64
"""The most characters of a press's id."""

Stop: TypeAlias = Callable[[Sequence[str], Listener, Rights], Awaitable[None]]
"""Stops robots and reports each answer. May raise GoalwireError."""


class Press:
    """One press of STOP. It goes on if whoever pressed has left."""

    def __init__(self, stop: Stop, robots: Sequence[str], by: Rights) -> None:
        self._answers: list[Answer] = []
        self._waiting: set[asyncio.Event] = set()
        self._task = asyncio.get_running_loop().create_task(self._run(stop, robots, by))
        self._task.add_done_callback(lambda _: self._wake())

    async def _run(self, stop: Stop, robots: Sequence[str], by: Rights) -> None:
        try:
            await stop(robots, self._tell, by)
        except GoalwireError as error:
            self._tell(Answer(robots[0] if robots else '', '', peer_text(error), is_done=False))

    def _tell(self, answer: Answer) -> None:
        self._answers.append(answer)
        self._wake()

    def _wake(self) -> None:
        for event in self._waiting:
            event.set()

    async def answers(self) -> AsyncGenerator[Answer, None]:
        """Yield the answers that there are, then those that come, until the last one."""
        seen, news = 0, asyncio.Event()
        self._waiting.add(news)
        try:
            while True:
                news.clear()
                for answer in self._answers[seen:]:
                    seen += 1
                    yield answer
                if seen == len(self._answers):
                    if self._task.done():
                        return
                    await news.wait()
        finally:
            self._waiting.discard(news)

    async def close(self) -> None:
        """End the press, because the console ends."""
        self._task.cancel()
        await asyncio.wait([self._task])


class Presses:
    """The latest presses of STOP, by the ids that browsers gave them."""

    def __init__(self, stop: Stop) -> None:
        self._stop = stop
        self._presses: dict[str, Press] = {}

    def begin(self, id_: str, robots: Sequence[str], by: Rights) -> Press:
        """Return the press of that id, which stops robots; it begins now unless it has begun already."""
        press = self._presses.get(id_)
        if press is None:
            press = self._presses[id_] = Press(self._stop, robots, by)
            while len(self._presses) > MOST:
                del self._presses[next(iter(self._presses))]
        return press

    def get(self, id_: str) -> Press | None:
        """Return the press of that id; None if this console does not know it."""
        return self._presses.get(id_)

    async def close(self) -> None:
        """End all presses."""
        for press in self._presses.values():
            await press.close()
