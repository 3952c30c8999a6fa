"""An open mission's code is changed in fifty ways: it goes on, or it is stuck at the step that differs."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from helpers.missions import Base, Robot, play

from goalwire.missions import Definition, MissionState
from goalwire.missions.dry_replay import why_stuck
from goalwire.missions.journal_store import Store

STEPS = [
    "await m.action(Fibonacci, 'drive').call(order=1)",
    "await m.client(Trigger, 'tare', idempotent=True).call(timeout=20.0)",
    'await m.sleep(1.0)',
    "await m.action(Fibonacci, 'drive').call(order=2)",
    'await m.now()',
    'await m.run(abs, -3)',
    "await m.action(Fibonacci, 'drive').call(order=4)",
    'await m.random()',
    "await m.action(Fibonacci, 'drive').call(order=5)",
    'await m.sleep(2.0)',
]
OTHERS = {
    'drive': 'fly',
    'tare': 'reset',
    'sleep': 'sleep_until',
    'now': 'random',
    'abs': 'float',
    'random': 'now',
}
"""Names in the code, and others for them."""
ARGUMENTS = {
    'order=1': 'order=3', 'order=2': 'order=3', 'order=4': 'order=3', 'order=5': 'order=3',
    'timeout=20.0': 'timeout=30.0', '(1.0)': '(1.5)', '(2.0)': '(2.5)', '-3': '-4',
}  # fmt: skip


class Mutant(NamedTuple):
    """A changed program."""

    change: str
    steps: list[str]
    differs_at: int
    """The first step that is another one than before."""


def replace_first(text: str, table: dict[str, str]) -> str:
    """Replace what is found first of the table's keys."""
    found = next((key for key in table if key in text), None)
    return text if found is None else text.replace(found, table[found], 1)


def mutants() -> Iterator[Mutant]:
    """Change each step in up to seven ways."""
    for at, step in enumerate(STEPS):
        before, after = STEPS[:at], STEPS[at + 1 :]
        yield Mutant(f'insert before {at}', [*before, "await m.approve('go on?')", step, *after], at)
        yield Mutant(f'remove {at}', [*before, *after], at)
        yield Mutant(f'do {at} twice', [*before, step, step, *after], at + 1)
        yield Mutant(f'end before {at}', before, at)
        yield Mutant(f'rename {at}', [*before, replace_first(step, OTHERS), *after], at)
        if replace_first(step, ARGUMENTS) != step:
            yield Mutant(f'other arguments of {at}', [*before, replace_first(step, ARGUMENTS), *after], at)
        if after:
            yield Mutant(f'swap {at}', [*before, after[0], step, *after[1:]], at)


def define(steps: list[str]) -> Definition:
    """Return a mission of these steps."""
    lines = [
        'from example_interfaces.action import Fibonacci',
        'from std_srvs.srv import Trigger',
        'from goalwire.missions import mission',
        "@mission(resume='auto')",
        'async def errand(m):',
        *(f'    {step}' for step in steps),
        "    return 'done'",
    ]
    names: dict[str, Definition] = {}
    exec('\n'.join(lines), names)
    return names['errand']


@pytest.mark.parametrize('driven', [1, 2, 3])
def test_changed_code_goes_on_or_is_stuck_at_the_step_that_differs(base: Base, driven: int) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            async with base.runner(define(STEPS)) as runner:
                run = await runner.start(define(STEPS), id='m')
                await robot.until(driven)
                known = 1 + max(entry.step for entry in run.entries())
            with Store(base.path) as store:
                row = store.mission('m')
                entries = store.entries('m')
            assert row is not None
            assert await why_stuck(row, define(STEPS), entries) == ''
            fit = stuck = 0
            for mutant in mutants():
                why = await why_stuck(row, define(mutant.steps), entries)
                if mutant.differs_at < known:
                    assert re.match(f'step {mutant.differs_at + 1}[ ,]', why), f'{mutant.change}: {why}'
                    stuck += 1
                else:
                    assert why == '', mutant.change
                    fit += 1
            assert fit + stuck >= 50
            assert fit > 0 < stuck

    play(scenario)


@pytest.mark.parametrize('change', ['remove 0', 'swap 2', 'rename 3', 'other arguments of 3'])
def test_a_runner_with_changed_code_does_no_step_and_goes_on_with_the_old_code(
    base: Base, change: str
) -> None:
    mutant = next(each for each in mutants() if each.change == change)

    async def scenario() -> None:
        async with Robot().served() as robot:
            async with base.runner(define(STEPS)) as runner:
                await runner.start(define(STEPS), id='m')
                await robot.until(2)
            async with base.runner(define(mutant.steps)) as runner:
                [run] = runner.missions()
                await run.until(MissionState.STUCK)
                assert re.match(f'step {mutant.differs_at + 1}[ ,]', run.why)
                await asyncio.sleep(100.0)
                assert robot.places == [1, 2]
            async with base.runner(define(STEPS)) as runner:
                [run] = runner.missions()
                assert await run.wait() == 'done'
            assert robot.places == [1, 2, 4, 5]

    play(scenario)
