"""The output of a program that ends by an exception nobody caught: its own frames, and at Ctrl-C nothing."""

from __future__ import annotations

import re
import signal
import sys
from pathlib import Path

import pytest
from helpers.markdown import ROOT, blocks
from helpers.processes import Program
from helpers.programs import server_of_programs

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')

README = {
    block.title: block.text for block in blocks(ROOT / 'README.md') if block.title and 'spin(' in block.text
}
FRAME = re.compile(r'File "([^"]*)", line (\d+)')

TICK = r"""
import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor

rclpy.init()
node = rclpy.create_node('lamp')

def tick():
    try:
        int('x')
    except ValueError as error:
        raise RuntimeError('two\nlines\x1b[2J') from error

async def later():
    tick()

node.create_timer(0.01, {callback})
with {executor} as executor:
    executor.add_node(node)
    executor.spin()
"""

READY = "rclpy.get_global_executor().create_task(print, 'ready')"
"""Printed from within the spin: before it Ctrl-C interrupts the program itself."""

IN_THREAD = """\
import threading, rclpy

rclpy.init()
node = rclpy.create_node('lamp')
node.create_timer(0.01, lambda: 1 / 0)
thread = threading.Thread(target=rclpy.spin, args=(node,), name='spinner')
thread.start()
thread.join()
print('over')
"""

SPINS_IN_THREAD = """\
import threading, rclpy

rclpy.init()
node = rclpy.create_node('lamp')
thread = threading.Thread(target=rclpy.spin, args=(node,))
thread.start()
node.create_timer(0.01, rclpy.try_shutdown)
thread.join()
print('over')
"""

MISUSE = """\
import rclpy

rclpy.init()
node = rclpy.create_node('lamp')
node.create_publisher({arguments})
"""

LATE = """\
import os, signal, sys, threading, rclpy
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from example_interfaces.srv import AddTwoInts
from std_msgs.msg import String

ended = threading.Event()
signal.signal(signal.SIGTERM, lambda *_: ended.set())  # runs after the context has ended
rclpy.init()
node = rclpy.create_node('lamp')
publisher = node.create_publisher(String, 'chatter', 10)
client = node.create_client(AddTwoInts, 'add')

def publish():
    {end}
    {late}

def spin():
    with {executor}() as executor:
        executor.add_node(node)
        executor.create_task(publish)
        executor.spin()

if 'guarded' in sys.argv:
    try:
        spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
else:
    spin()
"""
"""A callback during which the context ends, and which then goes on as before."""

OWN_LOOP = """\
import time, rclpy

rclpy.init()
node = rclpy.create_node('lamp')
print('ready', flush=True)
while True:
    time.sleep(0.1)
"""

ASYNCIO = """\
import asyncio
from std_msgs.msg import String
import goalwire

async def main():
    async with goalwire.Node('lamp') as node:
        messages = node.subscription(String, 'chatter')
        print('ready', flush=True)
        async for message in messages:
            print(message)

asyncio.run(main())
"""

HOOKED = """\
import sys, threading
sys.excepthook = lambda kind, error, trace: print('mine:', error)
threading.excepthook = mine = lambda arguments: None
import rclpy
rclpy.init()
print(threading.excepthook is mine)
rclpy.create_node('lamp').create_publisher(5, 'chatter', 10)
"""


def script(folder: Path, text: str) -> Path:
    file = folder / 'lamp.py'
    file.write_text(text, encoding='utf-8')
    return file


def run(file: Path, env: dict[str, str], *arguments: str) -> Program:
    """Start a program in a process which has imported rclpy already."""
    return Program(file, *arguments, env=env, server=server_of_programs())


def failed(file: Path, env: dict[str, str]) -> str:
    with run(file, env) as program:
        assert program.wait() == 1
        return program.output


def own_frames(file: Path, output: str) -> list[int]:
    frames = FRAME.findall(output)
    assert {name for name, _ in frames} == {str(file)}
    return [int(line) for _, line in frames]


@pytest.mark.parametrize('callback', ['tick', 'later'])
@pytest.mark.parametrize('executor', ['SingleThreadedExecutor()', 'MultiThreadedExecutor()'])
def test_an_exception_of_a_callback_shows_the_programs_frames(
    tmp_path: Path, isolated: dict[str, str], callback: str, executor: str
) -> None:
    file = script(tmp_path, TICK.format(callback=callback, executor=executor))
    output = failed(file, isolated)
    lines = file.read_text(encoding='utf-8').splitlines()
    frames = [lines[number - 1].strip().split('(')[0] for number in own_frames(file, output)]
    coroutine = ['tick'] if callback == 'later' else []
    assert frames == ['int', 'executor.spin', *coroutine, 'raise RuntimeError']
    assert 'The above exception was the direct cause' in output
    assert re.search(
        r'\(\d+ frames of goalwire are not shown: GOALWIRE_FULL_TRACEBACKS=1 shows them\)', output
    )
    assert output.endswith('RuntimeError: two\n  lines\\x1b[2J')


def test_all_frames_are_shown_to_whoever_asks(tmp_path: Path, isolated: dict[str, str]) -> None:
    file = script(tmp_path, TICK.format(callback='tick', executor='SingleThreadedExecutor()'))
    output = failed(file, {**isolated, 'GOALWIRE_FULL_TRACEBACKS': '1'})
    assert any('single_threaded.py' in name for name, _ in FRAME.findall(output))
    assert 'not shown' not in output


@pytest.mark.parametrize('arguments', ['5, "chatter", 10', 'str, "chatter", 10', 'dict, "2", None'])
def test_misuse_ends_at_the_programs_own_line(
    tmp_path: Path, isolated: dict[str, str], arguments: str
) -> None:
    file = script(tmp_path, MISUSE.format(arguments=arguments))
    assert own_frames(file, failed(file, isolated)) == [5]


def test_a_thread_of_the_program_shows_its_own_frames_too(tmp_path: Path, isolated: dict[str, str]) -> None:
    with run(script(tmp_path, IN_THREAD), isolated) as program:
        output = program.succeed()
    assert 'Exception in thread spinner:' in output
    assert 'ZeroDivisionError' in output
    assert not any('goalwire' in name for name, _ in FRAME.findall(output))


def test_a_thread_that_spins_ends_quietly_with_its_context(tmp_path: Path, isolated: dict[str, str]) -> None:
    with run(script(tmp_path, SPINS_IN_THREAD), isolated) as program:
        assert program.succeed() == 'over'


LATE_USES = {
    'publish': 'publisher.publish(String())',
    'call': 'client.call(AddTwoInts.Request())',
    'create': "node.create_publisher(String, 'other', 10)",
    'node': "rclpy.create_node('other')",
}


@pytest.mark.parametrize(
    ('use', 'executor'),
    [
        *((use, 'SingleThreadedExecutor') for use in LATE_USES),
        ('publish', 'MultiThreadedExecutor'),
        *(
            pytest.param(use, 'MultiThreadedExecutor', marks=[pytest.mark.slow, pytest.mark.long])
            for use in ('call', 'create', 'node')
        ),
    ],
)
def test_a_callback_that_goes_on_after_sigterm_ends_the_program_as_usual(
    tmp_path: Path, isolated: dict[str, str], use: str, executor: str
) -> None:
    """A use fails because its context has ended: under the second executor each run has one use."""
    end = 'os.kill(os.getpid(), signal.SIGTERM); ended.wait()'
    text = LATE.format(end=end, late=LATE_USES[use], executor=executor)
    file = script(tmp_path, text)
    with run(file, isolated, 'guarded') as program:
        assert program.succeed() == ''
    with run(file, isolated) as program:
        status = program.wait()
        assert program.output == ''
    assert status == (0 if executor == 'MultiThreadedExecutor' else 1), 'that of a spin that SIGTERM ends'


def test_a_callback_that_goes_on_after_its_own_shutdown_is_told(
    tmp_path: Path, isolated: dict[str, str]
) -> None:
    text = LATE.format(end='rclpy.shutdown()', late=LATE_USES['publish'], executor='SingleThreadedExecutor')
    with run(script(tmp_path, text), isolated, 'guarded') as program:
        assert program.wait() == 1
        assert "ShutDownError: cannot publish on '/chatter'" in program.output


def test_hooks_of_others_stay(tmp_path: Path, isolated: dict[str, str]) -> None:
    """The program has an interpreter of its own: it sets its hooks before it imports rclpy."""
    with Program(script(tmp_path, HOOKED), env=isolated) as program:
        assert program.wait() == 1
        output = program.output
    assert output.startswith('True\nmine: ')
    assert 'Traceback' not in output


def test_the_readme_has_programs_that_spin() -> None:
    assert README.keys() == {'lamp.py', 'counter.py'}


@pytest.mark.also_on_dds
@pytest.mark.parametrize('program', sorted(README))
def test_the_readmes_programs_end_quietly_at_ctrl_c(
    tmp_path: Path, isolated: dict[str, str], program: str
) -> None:
    text = README[program].replace('rclpy.init()', f'rclpy.init()\n{READY}')
    _ends_quietly(script(tmp_path, text), isolated)


def test_asyncios_programs_do_too(tmp_path: Path, isolated: dict[str, str]) -> None:
    _ends_quietly(script(tmp_path, ASYNCIO), isolated)


def _ends_quietly(file: Path, env: dict[str, str]) -> None:
    """Send Ctrl-C to a program that is ready."""
    with run(file, env) as program:
        program.expect('^ready$')
        told = program.output
        program.send_signal(signal.SIGINT)
        assert program.wait() == -signal.SIGINT
        assert program.output == told


def test_ctrl_c_in_the_programs_own_code_shows_where(tmp_path: Path, isolated: dict[str, str]) -> None:
    file = script(tmp_path, OWN_LOOP)
    with run(file, isolated) as program:
        program.expect('ready')
        program.send_signal(signal.SIGINT)
        assert program.wait() == -signal.SIGINT
        assert len(own_frames(file, program.output)) == 1
        assert program.output.endswith('KeyboardInterrupt')
