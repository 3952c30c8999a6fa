"""The process helper itself: a test that waits in vain must say why."""

from __future__ import annotations

import os
import select
import signal
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.forking import ForkServer
from helpers.patience import PATIENCE
from helpers.processes import Program

Run: TypeAlias = 'partial[Program]'


@pytest.fixture(scope='module')
def server() -> Iterator[ForkServer]:
    with ForkServer(['textwrap'], os.environ) as started:
        yield started


@pytest.fixture(params=['interpreter', 'forked'])
def run(request: pytest.FixtureRequest) -> Run:
    """Start a program, both ways."""
    if request.param == 'interpreter':
        return partial(Program)
    if sys.platform != 'linux':
        pytest.skip('ends of processes that are no children are told on Linux')
    return partial(Program, server=request.getfixturevalue('server'))


def test_lines_are_expected_one_after_the_other(run: Run) -> None:
    with run('print("one"); print("two"); print("one more")') as program:
        assert program.expect('one').group() == 'one'
        assert program.expect(r'one (\w+)').group(1) == 'more'
        assert program.wait() == 0


def test_lines_are_expected_in_any_order(run: Run) -> None:
    with run('print("one"); print("two"); print("three"); print("one more")') as program:
        program.expect_each('three', 'one', 'two')
        assert program.expect(r'one ?(\w*)').group(1) == 'more'
        with pytest.raises(AssertionError, match="ended without a line matching 'three'"):
            program.expect_each('three', 'one')


def test_a_line_that_never_comes_is_reported_with_what_came_instead(run: Run) -> None:
    with (
        run('print("something else"); raise SystemExit(3)') as program,
        pytest.raises(AssertionError, match=r"(?s)ended without .*'ready'.*something else"),
    ):
        program.expect('ready')


def test_a_line_that_is_late_is_reported(run: Run) -> None:
    with (
        run('print("started"); input()') as program,
        pytest.raises(AssertionError, match=r'ran for 0.1 s without'),
    ):
        program.expect('ready', timeout=0.1)


def test_errors_are_part_of_the_output(run: Run) -> None:
    with run('import sys; print("to stderr", file=sys.stderr); 1 / 0') as program:
        assert program.wait() == 1
        assert 'to stderr' in program.output
        assert 'ZeroDivisionError' in program.output


def test_a_program_that_fails_does_not_succeed(run: Run) -> None:
    with run('raise SystemExit("broken")') as program, pytest.raises(AssertionError, match='broken'):
        program.succeed()


def test_a_program_from_a_file_gets_its_arguments_and_input(run: Run, tmp_path: Path) -> None:
    script = tmp_path / 'script.py'
    script.write_text('import sys; print(sys.argv[1:], input())')
    with run(script, 'a', '-b') as program:
        program.write_line('hello')
        assert program.succeed() == "['a', '-b'] hello"


@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
def test_a_signal_reaches_the_program(run: Run) -> None:
    with run('print("ready"); input()') as program:
        program.expect('ready')
        program.send_signal(signal.SIGTERM)
        assert program.wait() == -signal.SIGTERM


@pytest.mark.skipif(sys.platform == 'win32', reason='process groups of POSIX')
def test_children_of_the_program_are_killed_with_it(run: Run) -> None:
    source = """
        import subprocess, sys
        code = 'import time; print("up", flush=True); time.sleep(1000)'
        child = subprocess.Popen([sys.executable, '-c', code])
        print('child', child.pid)
        child.wait()
    """
    with run(source) as program:
        child = int(program.expect(r'child (\d+)').group(1))
        program.expect('up')
        os.kill(child, 0)
    # close() has returned, so the pipe both wrote to is at its end: nobody of the group is left.
    assert program.wait() == -signal.SIGKILL


def test_forked_programs_are_told_of_their_own_ends(server: ForkServer, tmp_path: Path) -> None:
    """The pipe that tells of the first one's end is not held open by the second."""
    with (
        Program('print("ready"); input()', server=server) as first,
        Program('print("ready"); input(); raise SystemExit(4)', server=server, cwd=tmp_path) as second,
    ):
        first.expect('ready')
        second.expect('ready')
        first.write_line('')
        assert first.wait() == 0
        second.write_line('')
        assert second.wait() == 4


def test_a_forked_program_sees_what_an_interpreter_shows_it(run: Run, tmp_path: Path) -> None:
    script = tmp_path / 'shows.py'
    script.write_text(
        'import os, sys\n'
        'print(sys.argv, __name__, sys.path[0], __file__, os.getcwd(), os.environ)\n'
        'print(os.getpgid(0) == os.getpid(), os.listdir("/proc/self/fd"))\n'
        '1 / 0\n'
    )
    env = {'HOME': '/nowhere', 'LC_ALL': 'C.UTF-8'}
    with (
        run(script, 'a', env=env, cwd=tmp_path) as program,
        Program(script, 'a', env=env, cwd=tmp_path) as other,
    ):
        assert program.wait() == other.wait() == 1
        assert program.output == other.output


def test_a_forked_program_has_programs_forked_and_the_server_outlives_it() -> None:
    """A child of a program that was killed sees that its input is closed; the server forks the next one."""
    asks = """
        from helpers.forking import server_of_this_program
        child = server_of_this_program().start(
            'print("child", flush=True); input()', [], environment={'PYTHONUNBUFFERED': '1'}
        )
        print(child.pid, child.stdout.readline().decode(), end='', flush=True)
        input()
    """
    env = {**os.environ, 'PYTHONPATH': str(Path(__file__).parents[1])}
    with ForkServer(['helpers.forking'], env) as server:
        with Program(asks, server=server) as asking:
            child = os.pidfd_open(int(asking.expect(r'^(\d+) child$')[1]))
            asking.kill()
            asking.wait()
        poll = select.poll()
        poll.register(child, select.POLLIN)
        assert poll.poll(PATIENCE * 1000), 'the child has not ended'
        os.close(child)
        with Program('print(1)', server=server) as program:
            assert program.succeed() == '1'


def test_forked_programs_end_with_the_tests_that_started_them() -> None:
    tests = """
        import os
        from helpers.forking import ForkServer
        server = ForkServer([], os.environ)
        child = server.start('import time; print("runs", flush=True); time.sleep(600)', [], environment={})
        print(child.pid, child.stdout.readline().decode(), end='', flush=True)
        input()
    """
    env = {**os.environ, 'PYTHONPATH': str(Path(__file__).parents[1])}
    with Program(tests, env=env) as running:
        pid = int(running.expect(r'^(\d+) runs$')[1])
        child = os.pidfd_open(pid)
        running.kill()
    poll = select.poll()
    poll.register(child, select.POLLIN)
    has_ended = bool(poll.poll(PATIENCE * 1000))
    os.close(child)
    if not has_ended:
        os.kill(pid, signal.SIGKILL)
    assert has_ended


def test_the_lines_of_a_forked_program_are_whole_even_if_its_server_was_started_unbuffered() -> None:
    """Each piece of a print is written by itself there, and a line of the log can come between."""
    source = """
        import sys, threading

        def log():
            for _ in range(3000):
                print('logged', file=sys.stderr)

        logger = threading.Thread(target=log)
        logger.start()
        for number in range(3000):
            print('number', number)
        logger.join()
    """
    with (
        ForkServer(['threading'], {**os.environ, 'PYTHONUNBUFFERED': '1'}) as server,
        Program(source, server=server) as program,
    ):
        lines = program.succeed().splitlines()
    assert [line for line in lines if line != 'logged'] == [f'number {number}' for number in range(3000)]
