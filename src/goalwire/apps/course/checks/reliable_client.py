"""Exercise 4: a call with a time limit for each attempt, growing pauses, and a last attempt."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from goalwire.apps.course.bench import alone, wait_for_node
from goalwire.apps.course.student import Student, Wrong

if TYPE_CHECKING:
    from humanoid_interfaces.srv import GetBatteryStatus

SERVICE = 'get_battery_status'
ATTEMPTS = 4
ANSWERS_WITHIN = 0.5
LEAST_GROWTH = 0.15
"""Seconds by which the last pause must exceed the shortest one before it."""
ENDS_WITHIN = 8.0
"""Seconds that the program may run after its node appeared; a correct one needs at most half of them."""

THIRD = 'the server of the check answers the third request only'


class Server:
    """A service that leaves its first requests without an answer."""

    def __init__(self, deaf: int) -> None:
        self._deaf = deaf
        self.times: list[float] = []
        """When each request came, in s."""

    async def answer(self, _request: GetBatteryStatus.Request) -> GetBatteryStatus.Response:
        """Answer a request, unless it is one of the first `deaf` requests."""
        from humanoid_interfaces.srv import GetBatteryStatus
        from sensor_msgs.msg import BatteryState

        self.times.append(monotonic())
        if len(self.times) <= self._deaf:
            await asyncio.Event().wait()
        return GetBatteryStatus.Response(battery=BatteryState(percentage=0.42, present=True))

    def gaps(self) -> list[float]:
        """Return the seconds between each request and the next."""
        return [later - earlier for earlier, later in zip(self.times, self.times[1:], strict=False)]


async def steps(file: Path) -> AsyncIterator[str]:
    """Yield a sentence for each step that the program passes; raise Wrong at the first mistake."""
    async with _serve(file, deaf=0) as (server, student):
        await _insist_on_success(student, 'the service answers at once')
        _count(server, 1, 'the service answers at once')
        yield 'it shows the answer, after a single request'
    async with _serve(file, deaf=2) as (server, student):
        await _insist_on_success(student, THIRD)
        _count(server, 3, THIRD)
        yield 'it asks again if no answer comes'
    async with _serve(file, deaf=100) as (server, student):
        await _insist_on_failure(student, 'no request is ever answered', server)
        _count(server, ATTEMPTS, 'no request is ever answered')
        yield f'it gives up after {ATTEMPTS} attempts, and its exit code says so'
        judge_pauses(server.gaps())
        yield 'its pauses grow'
    async with alone() as node, Student(file) as student:
        await wait_for_node(node, student)
        await _insist_on_failure(student, 'there is no server at all')
        yield 'it gives up if there is no server'


@asynccontextmanager
async def _serve(file: Path, *, deaf: int) -> AsyncIterator[tuple[Server, Student]]:
    """Run the program beside a server that leaves the first `deaf` requests without an answer."""
    from humanoid_interfaces.srv import GetBatteryStatus

    server = Server(deaf)
    async with alone() as node:
        node.service(GetBatteryStatus, SERVICE, server.answer)
        async with Student(file) as student:
            await wait_for_node(node, student)
            yield server, student


def judge_pauses(gaps: Sequence[float]) -> None:
    """Raise Wrong if the seconds between requests do not grow.

    On a busy machine the first gap may be longer than its pause: there the program spins for the first time.
    So the last gap is compared with the shortest one before it.
    """
    listed = ', '.join(f'{gap:.2f}' for gap in gaps)
    if max(gaps) < ANSWERS_WITHIN + LEAST_GROWTH:
        raise Wrong(
            f'there is no pause between attempts: the requests come {listed} s after one another',
            'sleep between two attempts, 0.2 s at first: a server in trouble needs time, not more requests',
        )
    if gaps[-1] - min(gaps[:-1]) < LEAST_GROWTH:
        raise Wrong(
            f'the pauses do not grow: the requests come {listed} s after one another',
            'let the pause grow, as by pause *= 2: a server in trouble needs time, not more requests',
        )


async def _insist_on_success(student: Student, case: str) -> None:
    code = await _end(student, case)
    if code != 0:
        raise Wrong(f'{case}, and the exit code is {code}', f'it should be 0\n{student.last_lines()}')
    if '42' not in student.output:
        raise Wrong('the answer says 42 %, and the program does not show it', 'print percentage as percent')


async def _insist_on_failure(student: Student, case: str, server: Server | None = None) -> None:
    if await _end(student, case, server) == 0:
        raise Wrong(f'{case}, and the exit code is 0', 'end with sys.exit(1) once all attempts have failed')
    if not student.output.strip():
        raise Wrong(f'{case}, and the program says nothing', 'tell the user what was tried, and how often')


async def _end(student: Student, case: str, server: Server | None = None) -> int:
    def advise() -> str:
        if server is not None and len(server.times) > 1:
            return (
                f'{case}, and {len(server.times)} requests came until then: '
                f'give up after {ATTEMPTS} attempts, and wait {ANSWERS_WITHIN:g} s at most for each answer'
            )
        return (
            f'{case}. Every wait needs a limit: wait_for_service(timeout_sec=…), '
            'spin_until_future_complete(node, future, timeout_sec=…)'
        )

    return await student.wait(ENDS_WITHIN, advise)


def _count(server: Server, wanted: int, case: str) -> None:
    if len(server.times) != wanted:
        raise Wrong(
            f'{case}, and {len(server.times)} requests came instead of {wanted}',
            f'the task wants {ATTEMPTS} attempts at most, and none after an answer',
        )
