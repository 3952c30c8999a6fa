"""The fleet under chaos: problems in its books, partitions by its relay, and a short run."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from helpers.isolation import free_port
from helpers.loops import run
from helpers.markdown import ROOT

from benchmarks.fleet.books import Books
from benchmarks.fleet.slow_links import Faults, Relay

SENT, ENDED = 'sent\tgoal\ta\n', 'ended\tgoal\ta\tSUCCEEDED\n'
LOST = 'ended\tgoal\ta\tServerLostError\n'
REFUSED = 'ended\tgoal\ta\tGoalRefused\n'
PARTITION_S = 0.3


def books_of(folder: Path, told: str, executed: str = '', handled: str = '') -> Books:
    for name, text in (('told', told), ('executed', executed), ('handled', handled)):
        (folder / name).write_text(text, encoding='utf-8')
    return Books(folder)


@pytest.mark.parametrize(
    ('told', 'executed'),
    [(SENT + ENDED, 'a\n'), (SENT + LOST, 'a\n'), (SENT + LOST, ''), (SENT + REFUSED, '')],
)
def test_what_ran_once_or_is_told_to_have_failed_is_no_problem(
    tmp_path: Path, told: str, executed: str
) -> None:
    assert books_of(tmp_path, told, executed).problems == []


@pytest.mark.parametrize(
    ('told', 'executed', 'problem'),
    [
        (SENT, 'a\n', 'goal a never ended, and ran 1 times'),
        (SENT + ENDED, 'a\na\n', 'goal a ran 2 times: SUCCEEDED'),
        (SENT + ENDED, '', 'goal a succeeded, and no robot has run it'),
        (SENT + REFUSED, 'a\n', 'goal a ran, though it ended as GoalRefused'),
        ('', 'a\n', 'a robot has run goal a, which nobody has sent'),
        (SENT + ENDED + ENDED, 'a\n', 'goal a ended twice, or was never sent: SUCCEEDED'),
        (SENT + SENT + ENDED, 'a\n', 'goal a was sent twice'),
    ],
)
def test_what_does_not_balance_is_a_problem(tmp_path: Path, told: str, executed: str, problem: str) -> None:
    assert books_of(tmp_path, told, executed).problems == [problem]


def test_the_table_counts_what_has_failed_by_whether_it_ran(tmp_path: Path) -> None:
    told = ''.join(
        f'sent\tcall\t{number}\nended\tcall\t{number}\t{end}\n'
        for number, end in enumerate(('SUCCEEDED', 'DeadlineError', 'DeadlineError', 'NoServerError'))
    )
    books = books_of(tmp_path, told, handled='0\n1\n')
    assert books.problems == []
    assert books.table().splitlines()[-1] == '| call | 4 | 1 | 2 | 1 | DeadlineError 2, NoServerError 1 |'


@pytest.mark.parametrize('everything', [True, False])
def test_a_partitioned_link_is_silent_and_loses_nothing(*, everything: bool) -> None:
    async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while chunk := await reader.read(100):
            writer.write(chunk)
        writer.close()

    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        ports = free_port(), free_port()
        relay = Relay(ports[1], Faults(0.0, 1e9, 0.0, 0.0))
        async with (
            await asyncio.start_server(echo, '127.0.0.1', ports[1]),
            await asyncio.start_server(relay.connect, '127.0.0.1', ports[0]),
        ):
            reader, writer = await asyncio.open_connection('127.0.0.1', ports[0])
            writer.write(b'before')
            assert await reader.readexactly(6) == b'before'
            began = loop.time()
            relay.partition(PARTITION_S, everything=everything)
            writer.write(b'during')
            assert await reader.readexactly(6) == b'during'
            assert loop.time() - began >= PARTITION_S
            writer.write_eof()
            assert await reader.read() == b''
            writer.close()
            await writer.wait_closed()

    run(scenario())


def test_a_link_breaks_and_may_be_made_again() -> None:
    async def hold(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()

    async def scenario() -> None:
        ports = free_port(), free_port()
        relay = Relay(ports[1], Faults(0.0, 1e9, 0.0, 0.05))
        async with (
            await asyncio.start_server(hold, '127.0.0.1', ports[1]),
            await asyncio.start_server(relay.connect, '127.0.0.1', ports[0]),
        ):
            for _ in range(3):
                reader, writer = await asyncio.open_connection('127.0.0.1', ports[0])
                with suppress(ConnectionError):
                    assert await reader.read() == b''
                writer.close()
            assert relay.seen['breaks'] == 3

    run(scenario())


@pytest.mark.slow
def test_the_books_of_a_short_run_balance() -> None:
    done = subprocess.run(
        [sys.executable, '-m', 'benchmarks.fleet', '--robots', '2', '--chaos', '0.1'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith('\n0 problems\n'), done.stdout
    assert '| goal of a job |' in done.stdout
