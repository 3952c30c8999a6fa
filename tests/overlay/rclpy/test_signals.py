"""Ctrl-C, SIGTERM and the other ends of a program, each in a process of its own."""

from __future__ import annotations

import signal
import sys

import pytest
from helpers.processes import Program

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')

SETUP = """
import threading
import time
import rclpy
from rclpy.node import Node
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
"""
BEGIN = """
rclpy.init()
node = Node('a')
"""
SPIN = """
print('spinning')
rclpy.spin(node)
"""
GUARDED = """
try:
    print('spinning')
    rclpy.spin(node)
except BaseException as error:
    print('caught', type(error).__name__, 'ok', rclpy.ok())
try:
    rclpy.shutdown()
except Exception as error:
    print(type(error).__name__, error)
"""


def run(
    env: dict[str, str], program: str, number: int | None = None, ready: str = 'spinning'
) -> tuple[int, str]:
    """Run a program, send it a signal once it says that it is ready; return its exit code and output."""
    with Program(SETUP + program, env=env) as running:
        if number is not None:
            running.expect(ready)
            running.send_signal(number)
        return running.wait(), running.output


def test_ctrl_c_ends_an_unguarded_spin(isolated: dict[str, str]) -> None:
    code, output = run(isolated, BEGIN + SPIN, signal.SIGINT)
    assert code == -signal.SIGINT
    # In spin it is quiet; on the way there, where the program's own line is what it ends, it is told as ever.
    assert output.splitlines()[-1] in {'spinning', 'KeyboardInterrupt'}


def test_ctrl_c_is_a_keyboard_interrupt(isolated: dict[str, str]) -> None:
    code, output = run(isolated, BEGIN + GUARDED, signal.SIGINT)
    assert code == 0
    assert 'caught KeyboardInterrupt ok False' in output
    assert 'RCLError failed to shutdown: rcl_shutdown already called on the given context' in output
    assert 'Traceback' not in output


def test_ctrl_c_that_is_caught_leaves_the_exit_status_to_the_program(isolated: dict[str, str]) -> None:
    """Python itself ends with -SIGINT if Ctrl-C has come while source that is a text was run."""
    program = "try: exec('raise KeyboardInterrupt')\nexcept KeyboardInterrupt: print('caught')"
    assert run(isolated, BEGIN + program) == (0, 'caught')


def test_sigterm_ends_an_unguarded_spin(isolated: dict[str, str]) -> None:
    code, output = run(isolated, BEGIN + SPIN, signal.SIGTERM)
    assert code == 1
    assert output == 'spinning'


def test_sigterm_is_an_external_shutdown(isolated: dict[str, str]) -> None:
    code, output = run(isolated, BEGIN + GUARDED, signal.SIGTERM)
    assert code == 0
    assert 'caught ExternalShutdownException ok False' in output
    assert 'RCLError failed to shutdown: rcl_shutdown already called on the given context' in output


LOOP = """
try:
    while rclpy.ok():
        print('spinning')
        rclpy.spin_once(node)
    print('loop ended')
except BaseException as error:
    print('caught', type(error).__name__)
"""


def test_ctrl_c_ends_a_loop_of_spin_once(isolated: dict[str, str]) -> None:
    code, output = run(isolated, BEGIN + LOOP, signal.SIGINT)
    assert code == 0
    assert 'caught KeyboardInterrupt' in output


def test_sigterm_ends_a_loop_of_spin_once(isolated: dict[str, str]) -> None:
    code, output = run(isolated, BEGIN + LOOP, signal.SIGTERM)
    assert code == 0
    # Between two calls the loop sees ok() first.
    assert 'caught ExternalShutdownException' in output or 'loop ended' in output


def test_ctrl_c_ends_spin_until_future_complete(isolated: dict[str, str]) -> None:
    program = """
try:
    print('spinning')
    rclpy.spin_until_future_complete(node, Future())
except KeyboardInterrupt:
    print('caught')
"""
    code, output = run(isolated, BEGIN + program, signal.SIGINT)
    assert code == 0
    assert 'caught' in output


MULTI = """
executor = MultiThreadedExecutor(4)
executor.add_node(node)
try:
    print('spinning')
    executor.spin()
    print('returned')
except BaseException as error:
    print('caught', type(error).__name__)
print('ok', rclpy.ok())
executor.shutdown()
"""


@pytest.mark.parametrize(
    ('number', 'end'),
    [(signal.SIGINT, 'caught KeyboardInterrupt'), (signal.SIGTERM, 'returned')],
    ids=['SIGINT', 'SIGTERM'],
)
def test_signals_end_the_multi_threaded_executor(isolated: dict[str, str], number: int, end: str) -> None:
    code, output = run(isolated, BEGIN + MULTI, number)
    assert code == 0
    assert output.splitlines()[-2:] == [end, 'ok False']


def test_ctrl_c_reaches_the_main_thread_and_ends_a_spin_elsewhere(isolated: dict[str, str]) -> None:
    program = """
def say(line):  # in one piece: two threads speak at once
    print(line + chr(10), end='')
executor = SingleThreadedExecutor()
executor.add_node(node)
def spin():
    try:
        print('spinning')
        executor.spin()
    except BaseException as error:
        say(f'thread: {type(error).__name__}')
thread = threading.Thread(target=spin)
try:
    thread.start()
    time.sleep(60)
except BaseException as error:
    say(f'main: {type(error).__name__}')
thread.join()
print('ok', rclpy.ok())
"""
    code, output = run(isolated, BEGIN + program, signal.SIGINT)
    assert code == 0
    for line in ('main: KeyboardInterrupt', 'thread: ExternalShutdownException', 'ok False'):
        assert line in output


def test_without_handlers_ctrl_c_leaves_the_context_open(isolated: dict[str, str]) -> None:
    program = BEGIN.replace('init()', 'init(signal_handler_options=SignalHandlerOptions.NO)') + GUARDED
    code, output = run(isolated, program, signal.SIGINT)
    assert code == 0
    assert 'caught KeyboardInterrupt ok True' in output
    assert 'RCLError' not in output


@pytest.mark.parametrize('executor', ['SingleThreadedExecutor', 'MultiThreadedExecutor'])
def test_without_handlers_a_ctrl_c_that_ends_no_sleep_is_heard_after_a_second(
    isolated: dict[str, str], executor: str
) -> None:
    """A signal just before the main thread's sleep does not end it, nor does one that another thread gets."""
    program = f"""
import _thread
import sys
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
executor = {executor}()
executor.add_node(rclpy.create_node('a'))
main = threading.get_ident()
def interrupt():
    while not sys._current_frames()[main].f_code.co_filename.endswith('waiters.py'):
        pass
    _thread.interrupt_main()  # as if a signal had come to this thread
threading.Thread(target=interrupt, daemon=True).start()
try:
    executor.spin()
except KeyboardInterrupt:
    print('caught, ok', rclpy.ok())
rclpy.shutdown()
"""
    code, output = run(isolated, program)
    assert code == 0
    assert 'caught, ok True' in output


def test_without_handlers_sigterm_just_kills(isolated: dict[str, str]) -> None:
    program = BEGIN.replace('init()', 'init(signal_handler_options=SignalHandlerOptions.NO)') + GUARDED
    code, _ = run(isolated, program, signal.SIGTERM)
    assert code == -signal.SIGTERM


def test_sys_exit_in_a_callback_ends_the_program(isolated: dict[str, str]) -> None:
    code, _ = run(
        isolated,
        BEGIN + 'import sys\nnode.create_timer(0.01, lambda: sys.exit(7))\nrclpy.spin(node)',
    )
    assert code == 7


@pytest.mark.parametrize('executor', ['SingleThreadedExecutor', 'MultiThreadedExecutor'])
def test_a_raising_service_ends_the_program(isolated: dict[str, str], executor: str) -> None:
    program = f"""
rclpy.init()
from std_srvs.srv import Trigger
node = Node('a')
def callback(request, response):
    raise ValueError('boom')
node.create_service(Trigger, 'go', callback)
client = node.create_client(Trigger, 'go')
assert client.wait_for_service(10)
client.call_async(Trigger.Request())
executor = {executor}()
executor.add_node(node)
executor.spin()
"""
    code, output = run(isolated, program)
    assert code == 1
    assert 'ValueError: boom' in output.splitlines()


ACTION = """
rclpy.init()
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
node = Node('a')
def execute(handle):
    {what}
server = ActionServer(node, Fibonacci, 'fib', execute)
client = ActionClient(node, Fibonacci, 'fib')
assert client.wait_for_server(10)
client.send_goal_async(Fibonacci.Goal(order=1))
rclpy.spin(node)
"""


@pytest.mark.parametrize(
    ('what', 'expected'),
    [('raise SystemExit(5)', 5), ('raise KeyboardInterrupt', -signal.SIGINT)],
    ids=['SystemExit', 'KeyboardInterrupt'],
)
def test_an_execute_callback_may_end_the_program(isolated: dict[str, str], what: str, expected: int) -> None:
    code, _ = run(isolated, ACTION.format(what=what))
    assert code == expected


def test_ctrl_c_during_an_execute_callback_ends_cleanly(isolated: dict[str, str]) -> None:
    program = """
rclpy.init()
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
node = Node('a')
def execute(handle):
    print('executing')
    while rclpy.ok():
        time.sleep(0.01)
    handle.abort()
    print('execute ended')
    return Fibonacci.Result()
server = ActionServer(node, Fibonacci, 'fib', execute)
client = ActionClient(node, Fibonacci, 'fib')
assert client.wait_for_server(10)
client.send_goal_async(Fibonacci.Goal(order=1))
executor = MultiThreadedExecutor(4)
executor.add_node(node)
try:
    executor.spin()
except KeyboardInterrupt:
    print('caught')
executor.shutdown()
node.destroy_node()
rclpy.try_shutdown()
"""
    code, output = run(isolated, program, signal.SIGINT, ready='executing')
    assert code == 0, output
    assert 'caught' in output
    assert 'execute ended' in output
    assert 'Traceback' not in output
