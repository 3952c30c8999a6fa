from __future__ import annotations

import io
import os
import subprocess
import sys
import textwrap
import threading

import pytest
from helpers.patience import PATIENCE

from goalwire.logging import LoggingSeverity, LogRecord, get_logger
from goalwire.logging.console import Console

RECORD = LogRecord(1, LoggingSeverity.WARN, 'a', 'x', 'f', '/f.py', 7)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class CountingStream(io.StringIO):
    flushes = 0

    def flush(self) -> None:
        self.flushes += 1


def printed(environment: dict[str, str], stream: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(sys, 'stderr', stream)
    Console.from_environment({'RCUTILS_CONSOLE_OUTPUT_FORMAT': '{severity} {message}', **environment})(RECORD)
    return stream.getvalue()


def test_lines_go_to_stderr_in_ros_2s_format(capsys: pytest.CaptureFixture[str]) -> None:
    Console.from_environment({})(RECORD)
    assert capsys.readouterr() == ('', '[WARN] [0000000000.000000001] [a]: x\n')


def test_an_empty_format_is_the_default_one(capsys: pytest.CaptureFixture[str]) -> None:
    Console.from_environment({'RCUTILS_CONSOLE_OUTPUT_FORMAT': ''})(RECORD)
    assert capsys.readouterr().err == '[WARN] [0000000000.000000001] [a]: x\n'


def test_use_stdout_sends_every_severity_there(capsys: pytest.CaptureFixture[str]) -> None:
    console = Console.from_environment({'RCUTILS_LOGGING_USE_STDOUT': '1'})
    for severity in list(LoggingSeverity)[1:]:
        console(RECORD._replace(severity=severity))
    out, err = capsys.readouterr()
    assert [line.split()[0] for line in out.splitlines()] == [
        '[DEBUG]',
        '[INFO]',
        '[WARN]',
        '[ERROR]',
        '[FATAL]',
    ]
    assert err == ''


@pytest.mark.parametrize(
    ('severity', 'colour'),
    [
        (LoggingSeverity.DEBUG, '\x1b[32m'),
        (LoggingSeverity.INFO, '\x1b[0m'),
        (LoggingSeverity.WARN, '\x1b[33m'),
        (LoggingSeverity.ERROR, '\x1b[31m'),
        (LoggingSeverity.FATAL, '\x1b[31m'),
    ],
)
def test_each_severity_has_its_colour(
    severity: LoggingSeverity, colour: str, capsys: pytest.CaptureFixture[str]
) -> None:
    environment = {'RCUTILS_COLORIZED_OUTPUT': '1', 'RCUTILS_CONSOLE_OUTPUT_FORMAT': '{message}'}
    Console.from_environment(environment)(RECORD._replace(severity=severity))
    assert capsys.readouterr().err == f'{colour}x\x1b[0m\n'


@pytest.mark.skipif(os.name == 'nt', reason='the old Windows console gets no colours')
def test_a_terminal_gets_colours_unasked(monkeypatch: pytest.MonkeyPatch) -> None:
    assert printed({}, Terminal(), monkeypatch) == '\x1b[33mWARN x\x1b[0m\n'


def test_a_terminal_gets_no_colours_where_they_are_off(monkeypatch: pytest.MonkeyPatch) -> None:
    assert printed({'RCUTILS_COLORIZED_OUTPUT': '0'}, Terminal(), monkeypatch) == 'WARN x\n'


def test_a_pipe_gets_no_colours_unasked(monkeypatch: pytest.MonkeyPatch) -> None:
    assert printed({}, io.StringIO(), monkeypatch) == 'WARN x\n'


@pytest.mark.parametrize(
    'name', ['RCUTILS_COLORIZED_OUTPUT', 'RCUTILS_LOGGING_USE_STDOUT', 'RCUTILS_LOGGING_BUFFERED_STREAM']
)
def test_a_switch_that_is_neither_0_nor_1_is_reported_and_ignored(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = printed({name: 'maybe'}, io.StringIO(), monkeypatch)
    assert text == f"goalwire: {name} is 'maybe', which is ignored: set it to 0 or 1\nWARN x\n"


@pytest.mark.parametrize(
    ('buffered', 'to_stdout', 'flushes'),
    [('', '0', 1), ('0', '0', 1), ('1', '0', 1), ('', '1', 0), ('0', '1', 1), ('1', '1', 1)],
)
def test_only_an_unconfigured_stdout_is_left_to_its_own_buffer(
    buffered: str, to_stdout: str, flushes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = CountingStream()
    monkeypatch.setattr(sys, 'stdout' if to_stdout == '1' else 'stderr', stream)
    environment = {'RCUTILS_LOGGING_BUFFERED_STREAM': buffered, 'RCUTILS_LOGGING_USE_STDOUT': to_stdout}
    Console.from_environment(environment)(RECORD)
    assert stream.flushes == flushes


def test_a_closed_or_missing_stream_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    stream.close()
    console = Console.from_environment({})
    for replacement in (stream, None):
        monkeypatch.setattr(sys, 'stderr', replacement)
        console(RECORD)
    working = io.StringIO()
    monkeypatch.setattr(sys, 'stderr', working)
    console(RECORD)
    assert working.getvalue() == '[WARN] [0000000000.000000001] [a]: x\n'


def test_what_the_stream_cannot_encode_is_written_as_escapes(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding='ascii', errors='strict')
    monkeypatch.setattr(sys, 'stderr', stream)
    Console.from_environment({'RCUTILS_CONSOLE_OUTPUT_FORMAT': '{message}'})(
        RECORD._replace(message='é\ud800')
    )
    assert raw.getvalue() == b'\\xe9\\ud800' + os.linesep.encode()


def test_a_message_of_several_lines_is_printed_as_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    Console.from_environment({})(RECORD._replace(message='a\nb'))
    assert capsys.readouterr().err.endswith(']: a\nb\n')


def test_lines_of_many_threads_stay_whole(capfd: pytest.CaptureFixture[str]) -> None:
    logger = get_logger('a')
    barrier = threading.Barrier(8, timeout=PATIENCE)

    def say(letter: str) -> None:
        barrier.wait()
        for _ in range(100):
            logger.info(letter * 9000)

    threads = [threading.Thread(target=say, args=(letter,)) for letter in 'abcdefgh']
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    texts = [line.rpartition(': ')[2] for line in capfd.readouterr().err.splitlines()]
    assert len(texts) == 800
    assert all(len(text) == 9000 and len(set(text)) == 1 for text in texts)


def test_a_stream_that_logs_while_it_writes_does_not_lock_up(monkeypatch: pytest.MonkeyPatch) -> None:
    class Chatty(io.StringIO):
        busy = False

        def write(self, text: str) -> int:
            if not self.busy:
                self.busy = True
                get_logger('inner').info('while writing')
            return super().write(text)

    stream = Chatty()
    monkeypatch.setattr(sys, 'stderr', stream)
    get_logger('outer').info('x')
    assert [line.split('[')[-1] for line in stream.getvalue().splitlines()] == [
        'inner]: while writing',
        'outer]: x',
    ]


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='no fork here')
def test_a_forked_child_logs_even_if_a_thread_was_writing() -> None:
    program = textwrap.dedent("""
        import io, os, sys, threading
        from goalwire.logging import get_logger
        inside, leave = threading.Event(), threading.Event()
        real = sys.stderr
        class Slow(io.StringIO):
            def write(self, text):
                inside.set()
                leave.wait()
                return len(text)
        sys.stderr = Slow()
        thread = threading.Thread(target=lambda: get_logger('slow').info('x'))
        thread.start()
        inside.wait()
        child = os.fork()
        sys.stderr = real
        if child == 0:
            get_logger('child').info('alive')
            os._exit(0)
        leave.set()
        thread.join()
        sys.exit(os.waitpid(child, 0)[1])
    """)
    done = subprocess.run(
        [sys.executable, '-W', 'ignore', '-c', program],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert '[child]: alive' in done.stderr


def test_the_library_logs_without_heavy_imports() -> None:
    program = (
        'import sys; from goalwire.logging import get_logger; get_logger("a").info("x", once=True);'
        'print([name for name in ("numpy", "asyncio", "yaml", "rich", "inspect") if name in sys.modules])'
    )
    done = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, timeout=30, check=True
    )
    assert done.stdout.strip() == '[]'
