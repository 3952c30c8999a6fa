"""SIGINT and SIGTERM, each in a process of its own: rclpy's outcomes, as measured."""

from __future__ import annotations

import signal
import sys
import threading

import pytest
from helpers.execution import SmallContext, SmallNode
from helpers.processes import Program

from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.signals import signal_handlers
from goalwire.execution.signals.signal_handlers import SignalHandlerGuardCondition, SignalHandlerOptions

if sys.platform == 'win32':
    pytest.skip('POSIX signals', allow_module_level=True)

HEAD = """
import asyncio, sys, threading, time
from goalwire.execution.signals import signal_handlers
from goalwire.execution.future import Future
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.signals.signal_handlers import SignalHandlerOptions
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.time.steady_clock import SteadyClock

class Announcing(SteadyClock):
    '''Says when the first thread goes to sleep.'''
    __slots__ = ('silent',)
    def wait(self, waiter, deadline_ns):
        if not hasattr(self, 'silent'):
            self.silent = True
            print('parked')
        return super().wait(waiter, deadline_ns)

class Context:
    def __init__(self):
        self.shutdown_signal = ShutdownSignal(Announcing())
    def ok(self):
        return self.shutdown_signal.alive

context = Context()
signal_handlers.register(context.shutdown_signal)
signal_handlers.install_signal_handlers()
single, multi = SingleThreadedExecutor(context=context), MultiThreadedExecutor(4, context=context)
def ready():
    print('ready')
"""


def run(body: str, number: signal.Signals, when: str = 'ready') -> tuple[int, str]:
    """Run HEAD and `body`, send the signal when it prints `when`; return the exit code and its output."""
    with Program(HEAD + body) as program:
        program.expect(when)
        program.send_signal(number)
        code = program.wait(10)
        return code, program.output


def guarded(spin: str) -> str:
    return f"""

try:
    {spin}
    print('returned', context.ok())
except BaseException as error:
    print(type(error).__name__, repr(str(error)), context.ok())
"""


def test_sigint_ends_an_unguarded_spin_as_ctrl_c_does() -> None:
    code, output = run('single.spin()', signal.SIGINT, 'parked')
    assert code == -signal.SIGINT
    assert output.rstrip().endswith('KeyboardInterrupt')


def test_sigterm_ends_an_unguarded_spin_with_external_shutdown() -> None:
    code, output = run('single.spin()', signal.SIGTERM, 'parked')
    assert code == 1
    assert 'ExternalShutdownException' in output.splitlines()[-1]


@pytest.mark.parametrize(
    ('spin', 'number', 'outcome'),
    [
        ('single.spin()', signal.SIGINT, "KeyboardInterrupt '' False"),
        ('single.spin()', signal.SIGTERM, "ExternalShutdownException '' False"),
        ('while context.ok(): single.spin_once()', signal.SIGINT, "KeyboardInterrupt '' False"),
        ('while context.ok(): single.spin_once()', signal.SIGTERM, "ExternalShutdownException '' False"),
        ('single.spin_until_future_complete(Future())', signal.SIGINT, "KeyboardInterrupt '' False"),
        ('single.spin_until_future_complete(Future())', signal.SIGTERM, "ExternalShutdownException '' False"),
        ('multi.spin()', signal.SIGINT, "KeyboardInterrupt '' False"),
        ('multi.spin()', signal.SIGTERM, 'returned False'),
        ('multi.spin_until_future_complete(Future())', signal.SIGINT, "KeyboardInterrupt '' False"),
    ],
)
def test_a_signal_while_parked(spin: str, number: signal.Signals, outcome: str) -> None:
    code, output = run(guarded(spin), number, 'parked')
    assert code == 0
    assert outcome in output


@pytest.mark.parametrize('kind', ['single', 'multi'])
def test_sigint_while_a_callback_runs(kind: str) -> None:
    body = f"""
def busy():
    ready()
    time.sleep(5 if '{kind}' == 'single' else 0.2)
{kind}.create_task(busy)
begun = time.monotonic()
try:
    {kind}.spin()
except KeyboardInterrupt:
    print('interrupted', time.monotonic() - begun < 2, context.ok())
"""
    code, output = run(body, signal.SIGINT)
    assert code == 0
    assert 'interrupted True False' in output


@pytest.mark.parametrize('kind', ['single', 'multi'])
def test_sigterm_while_a_callback_runs_lets_it_end_and_spin_return(kind: str) -> None:
    body = f"""
def busy():
    ready()
    while context.ok():
        time.sleep(0.01)
    print('callback ends')
{kind}.create_task(busy)
{kind}.spin()
print('returned')
"""
    code, output = run(body, signal.SIGTERM)
    assert code == 0
    assert 'callback ends' in output
    assert 'returned' in output


@pytest.mark.parametrize('kind', ['single', 'multi'])
def test_sigint_while_a_coroutine_callback_waits(kind: str) -> None:
    body = f"""
async def waits():
    try:
        ready()
        await asyncio.sleep(3600)
    finally:
        print('cleaned up')
{kind}.create_task(waits)
try:
    {kind}.spin()
except KeyboardInterrupt:
    print('interrupted')
"""
    code, output = run(body, signal.SIGINT)
    assert code == 0
    assert 'interrupted' in output
    assert 'cleaned up' in output


def test_sigint_while_a_socket_is_watched() -> None:
    body = """
async def serve():
    server = await asyncio.start_server(lambda r, w: None, '127.0.0.1', 0)
    async with server:
        await server.serve_forever()
single.create_task(serve)
try:
    single.spin()
except KeyboardInterrupt:
    print('interrupted')
"""
    code, output = run(body, signal.SIGINT, 'parked')
    assert code == 0
    assert 'interrupted' in output


def test_a_second_ctrl_c_is_heard_too() -> None:
    body = """
single.create_task(ready)
try:
    single.spin()
except KeyboardInterrupt:
    print('first')
    try:
        print('ready again')
        time.sleep(10)
    except KeyboardInterrupt:
        print('second')
"""
    with Program(HEAD + body) as program:
        program.expect('ready')
        program.send_signal(signal.SIGINT)
        program.expect('ready again')
        program.send_signal(signal.SIGINT)
        assert program.wait(10) == 0
        assert 'second' in program.output


def test_sigint_with_spin_in_a_thread_and_main_asleep() -> None:
    body = """
def spin():
    try:
        single.spin()
    except BaseException as error:
        print(f'thread: {type(error).__name__}\\n', end='')
thread = threading.Thread(target=spin)
try:
    thread.start()
    time.sleep(10)
except KeyboardInterrupt:
    print('main: KeyboardInterrupt\\n', end='')
thread.join(5)
print(thread.is_alive(), context.ok())
"""
    code, output = run(body, signal.SIGINT, 'parked')
    assert code == 0
    for line in ('main: KeyboardInterrupt', 'thread: ExternalShutdownException', 'False False'):
        assert line in output


@pytest.mark.parametrize(
    ('number', 'code', 'text'),
    [(signal.SIGINT, 0, "KeyboardInterrupt '' True"), (signal.SIGTERM, -signal.SIGTERM, '')],
)
def test_without_handlers_signals_do_what_python_makes_of_them(
    number: signal.Signals, code: int, text: str
) -> None:
    # Python's own handler misses a signal that comes right before the main thread falls asleep, and runs at
    # its next wake-up. So no sleep is long here.
    body = """
signal_handlers.install_signal_handlers(SignalHandlerOptions.NO)
class Restless(Announcing):
    __slots__ = ()
    def wait(self, waiter, deadline_ns):
        return super().wait(waiter, self.now() + 50_000_000)
context.shutdown_signal.clock = Restless()
restless = SingleThreadedExecutor(context=context)
"""
    outcome, output = run(body + guarded('restless.spin()'), number, 'parked')
    assert outcome == code
    assert text in output


def test_sys_exit_in_a_callback_is_the_exit_code() -> None:
    for kind in ('single', 'multi'):
        with Program(HEAD + f'{kind}.create_task(sys.exit, 7)\n{kind}.spin()') as program:
            assert program.wait(10) == 7


def test_an_exception_in_a_callback_ends_the_program() -> None:
    for kind in ('single', 'multi'):
        with Program(HEAD + f'{kind}.create_task(lambda: 1 / 0)\n{kind}.spin()') as program:
            assert program.wait(10) == 1
            assert program.output.rstrip().endswith('ZeroDivisionError: division by zero')


def test_a_program_that_forgets_its_executors_ends_all_the_same() -> None:
    body = """
multi.spin_until_future_complete(multi.create_task(lambda: None))
async def waits():
    await asyncio.sleep(3600)
multi.create_task(waits); single.create_task(waits)
multi.spin_once(1); single.spin_once(1)
print('end of main')
"""
    with Program(HEAD + body) as program:
        assert program.wait(10) == 0
        assert program.output.split() == ['parked', 'end', 'of', 'main']


@pytest.mark.parametrize('attempt', range(3))
def test_a_signal_right_before_the_main_thread_falls_asleep_is_not_missed(attempt: int) -> None:
    body = """
import os, signal
class Late(SteadyClock):
    __slots__ = ()
    def wait(self, waiter, deadline_ns):
        if threading.current_thread() is threading.main_thread():
            threading.Thread(target=os.kill, args=(os.getpid(), signal.SIGTERM)).start()
        return super().wait(waiter, deadline_ns)
context.shutdown_signal.clock = Late()
late = MultiThreadedExecutor(4, context=context)
late.spin()
print('returned')
"""
    with Program(HEAD + body) as program:
        assert program.wait(10) == 0
        assert 'returned' in program.output


def test_a_forked_childs_signals_do_not_end_its_parents_contexts() -> None:
    body = """
import os, signal
child = os.fork()
if child == 0:
    signal.signal(signal.SIGTERM, lambda *_: os._exit(3))
    os.kill(os.getpid(), signal.SIGTERM)
    os._exit(4)
print('child', os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
deadline = context.shutdown_signal.clock.now() + 200_000_000
print('parent', Future().wait(deadline, shutdown_signal=context.shutdown_signal), context.ok())
"""
    with Program(HEAD + body) as program:
        assert program.wait(10) == 0
        assert 'child 3' in program.output
        assert 'parent False True' in program.output


def test_options_and_what_was_installed_before() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert signal_handlers.get_current_signal_handlers_options() is SignalHandlerOptions.NO
    try:
        signal_handlers.install_signal_handlers()
        assert signal_handlers.get_current_signal_handlers_options() is SignalHandlerOptions.ALL
        signal_handlers.install_signal_handlers(SignalHandlerOptions.SIGTERM)
        assert signal_handlers.get_current_signal_handlers_options() is SignalHandlerOptions.SIGTERM
        assert signal.getsignal(signal.SIGINT) is before[0]
    finally:
        signal_handlers.uninstall_signal_handlers()
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
    assert [option.name for option in SignalHandlerOptions] == ['NO', 'SIGINT', 'SIGTERM', 'ALL']


def test_what_is_no_option_is_refused() -> None:
    with pytest.raises(TypeError, match='must be SignalHandlerOptions, got 5'):
        signal_handlers.install_signal_handlers(5)  # type: ignore[arg-type]


def test_a_handler_that_the_program_installed_later_is_left_alone() -> None:
    before = signal.getsignal(signal.SIGTERM)

    def own(number: int, frame: object) -> None:
        """Stand in for a program's handler."""

    try:
        signal_handlers.install_signal_handlers(SignalHandlerOptions.SIGTERM)
        signal.signal(signal.SIGTERM, own)
        signal_handlers.uninstall_signal_handlers()
        assert signal.getsignal(signal.SIGTERM) is own
    finally:
        signal.signal(signal.SIGTERM, before)


def test_installing_on_another_thread_does_nothing() -> None:
    before = signal.getsignal(signal.SIGINT)
    thread = threading.Thread(target=signal_handlers.install_signal_handlers)
    thread.start()
    thread.join()
    assert signal.getsignal(signal.SIGINT) is before
    assert signal_handlers.get_current_signal_handlers_options() is SignalHandlerOptions.NO


def test_the_previous_handler_is_called_and_guard_conditions_are_triggered(
    context: SmallContext, single: SingleThreadedExecutor, node: SmallNode
) -> None:
    called: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _: called.append(number))
    guard = SignalHandlerGuardCondition()
    other = SmallContext()
    try:
        signal_handlers.install_signal_handlers(SignalHandlerOptions.SIGTERM)
        signal_handlers.register(other.shutdown_signal)
        signal.raise_signal(signal.SIGTERM)
        assert called == [signal.SIGTERM]
        assert not other.ok()
        assert other.shutdown_signal.reason == 'SIGTERM'
        assert context.ok()
        assert list(guard.work_queue._backlog) == [guard]
    finally:
        signal_handlers.unregister(other.shutdown_signal)
        guard.destroy()
        signal_handlers.uninstall_signal_handlers()
        signal.signal(signal.SIGTERM, before)
