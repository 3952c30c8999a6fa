"""Event loops and ROS in one process: every signal reaches whoever handles it, whoever came first.

The table of all cells is generated. The ordinary suite runs a diagonal of it, in which each loop, moment,
signal and handler meets each other at least once; `make long` runs all.
"""

from __future__ import annotations

import importlib.util
import re
import signal
import sys
from itertools import product, starmap
from pathlib import Path
from typing import NamedTuple

import pytest
from helpers.isolation import isolated_env
from helpers.patience import wait_for
from helpers.processes import Program
from helpers.wires import DDS, require

if sys.platform == 'win32':
    pytest.skip('POSIX signals', allow_module_level=True)

PROGRAM = Path(__file__).parent / 'programs' / 'loops.py'
LOOPS = {'asyncio': 'asyncio', 'uvloop': 'uvloop', 'trio': 'trio', 'anyio': 'anyio', 'qt': 'PySide6'}
"""Each loop, and the package that it comes with."""
WHENS = ('before', 'inside', 'after')
SIGNALS = ('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGCHLD')
HANDLERS = ('before', 'after', 'none')
WIRES = ('rmw_zenoh_cpp', DDS)
ODD = re.compile('Traceback|Warning|Exception ignored|Error')


class Cell(NamedTuple):
    """One program of the table."""

    loop: str
    when: str
    number: str
    handler: str

    @property
    def handler_stays(self) -> bool:
        """Whether the program's handler is there when the signal comes: a loop's own ends with the loop."""
        if self.handler == 'before' and self.when == 'after':
            return self.loop == 'qt'
        return self.handler != 'none'

    @property
    def is_ours(self) -> bool:
        """Whether goalwire's handler is there, too: it was not replaced by a later one."""
        if self.number not in {'SIGINT', 'SIGTERM'} or self.handler == 'after':
            return False
        # trio brings a handler of its own in place of Python's.
        return self != ('trio', 'before', 'SIGINT', 'none')


def exists(cell: Cell) -> bool:
    """Whether the loop allows for it: uvloop keeps SIGCHLD to itself, and leaves dead handlers behind."""
    if cell.loop != 'uvloop' or cell.handler == 'none':
        return True
    return cell.number != 'SIGCHLD' and (cell.when, cell.handler) != ('after', 'before')


CELLS = [cell for cell in starmap(Cell, product(LOOPS, WHENS, SIGNALS, HANDLERS)) if exists(cell)]
DIAGONAL = [
    cell
    for (row, loop), (column, number) in product(enumerate(LOOPS), enumerate(SIGNALS))
    for handler in [HANDLERS[(row + 2 * column + row // 3) % 3]]
    if exists(cell := Cell(loop, WHENS[(row + column) % 3], number, handler))
]


def play(cell: Cell, wire: str) -> None:
    """Run the cell's program, and hold what it says to what must come of the signal."""
    if importlib.util.find_spec(LOOPS[cell.loop]) is None:
        pytest.skip(f'{LOOPS[cell.loop]} is not installed')
    require(wire)
    number = signal.Signals[cell.number]
    with Program(PROGRAM, *cell, env=isolated_env(wire)) as program:
        program.expect('^ready$')
        program.send_signal(number)
        if number == signal.SIGHUP and not cell.handler_stays:
            assert program.wait() == -number
            return
        interrupts = number == signal.SIGINT and not cell.handler_stays
        wanted = set()
        if cell.handler_stays:
            wanted.add(f'the handler ran, ok {not cell.is_ours}')
        if interrupts and cell.loop != 'qt':
            wanted.add('KeyboardInterrupt')
        elif cell.is_ours:
            wanted.add('the spin was ended')
        wait_for(lambda: wanted <= {*program.output.splitlines()}, f'{wanted} from {cell}')
        program.write_line('leave')
        output = program.succeed()
    lines = output.splitlines()
    assert f'ok {not cell.is_ours}' in lines
    if not interrupts:  # else the program itself may be quicker
        assert ('the spin was ended' in lines) == cell.is_ours
    assert ('KeyboardInterrupt' in lines) == interrupts
    assert ('the loop works' in lines) == (not interrupts or cell.when == 'after')
    assert lines.count('end') == 1
    assert not ODD.search(output), output


@pytest.mark.slow
@pytest.mark.parametrize(('index', 'cell'), [*enumerate(DIAGONAL)], ids=['-'.join(cell) for cell in DIAGONAL])
def test_a_signal_reaches_whoever_handles_it(index: int, cell: Cell) -> None:
    play(cell, WIRES[(index + index // 4) % 2])


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize('transport', WIRES)
@pytest.mark.parametrize('cell', CELLS, ids=['-'.join(cell) for cell in CELLS])
def test_the_whole_table(cell: Cell, transport: str) -> None:
    play(cell, transport)
