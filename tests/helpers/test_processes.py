"""The process helper itself: a test that waits in vain must say why."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import pytest
from helpers.processes import Program


def test_lines_are_expected_one_after_the_other() -> None:
    with Program('print("one"); print("two"); print("one more")') as program:
        assert program.expect('one').group() == 'one'
        assert program.expect(r'one (\w+)').group(1) == 'more'
        assert program.wait() == 0


def test_lines_are_expected_in_any_order() -> None:
    with Program('print("one"); print("two"); print("three"); print("one more")') as program:
        program.expect_each('three', 'one', 'two')
        assert program.expect(r'one ?(\w*)').group(1) == 'more'
        with pytest.raises(AssertionError, match="ended without a line matching 'three'"):
            program.expect_each('three', 'one')


def test_a_line_that_never_comes_is_reported_with_what_came_instead() -> None:
    with (
        Program('print("something else"); raise SystemExit(3)') as program,
        pytest.raises(AssertionError, match=r"(?s)ended without .*'ready'.*something else"),
    ):
        program.expect('ready')


def test_a_line_that_is_late_is_reported() -> None:
    with (
        Program('print("started"); input()') as program,
        pytest.raises(AssertionError, match=r'ran for 0.1 s without'),
    ):
        program.expect('ready', timeout=0.1)


def test_errors_are_part_of_the_output() -> None:
    with Program('import sys; print("to stderr", file=sys.stderr); 1 / 0') as program:
        assert program.wait() == 1
        assert 'to stderr' in program.output
        assert 'ZeroDivisionError' in program.output


def test_a_program_that_fails_does_not_succeed() -> None:
    with Program('raise SystemExit("broken")') as program, pytest.raises(AssertionError, match='broken'):
        program.succeed()


def test_a_program_from_a_file_gets_its_arguments_and_input(tmp_path: Path) -> None:
    script = tmp_path / 'script.py'
    script.write_text('import sys; print(sys.argv[1:], input())')
    with Program(script, 'a', '-b') as program:
        program.write_line('hello')
        assert program.succeed() == "['a', '-b'] hello"


@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
def test_a_signal_reaches_the_program() -> None:
    with Program('print("ready"); input()') as program:
        program.expect('ready')
        program.send_signal(signal.SIGTERM)
        assert program.wait() == -signal.SIGTERM


@pytest.mark.skipif(sys.platform == 'win32', reason='process groups of POSIX')
def test_children_of_the_program_are_killed_with_it() -> None:
    source = """
        import subprocess, sys
        code = 'import time; print("up", flush=True); time.sleep(1000)'
        child = subprocess.Popen([sys.executable, '-c', code])
        print('child', child.pid)
        child.wait()
    """
    with Program(source) as program:
        child = int(program.expect(r'child (\d+)').group(1))
        program.expect('up')
        os.kill(child, 0)
    # close() has returned, so the pipe both wrote to is at its end: nobody of the group is left.
    assert program.wait() == -signal.SIGKILL
