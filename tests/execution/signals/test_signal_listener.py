"""The main thread inside the wire's library: signals bring it out. On DDS, each in a process of its own."""

from __future__ import annotations

import signal
import sys

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS

from goalwire.errors import TransportError
from goalwire.transport.dds.cyclone.library import find_library

if sys.platform == 'win32':
    pytest.skip('POSIX signals', allow_module_level=True)

HEAD = """
import asyncio, os, signal, sys, threading, time
import rclpy
from goalwire.execution.signals.signal_handlers import LISTENING
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

def begin(options=SignalHandlerOptions.ALL):
    rclpy.init(signal_handler_options=options)
    return rclpy.create_node('sleeper', start_parameter_services=False)

def when_it_leads(act):
    '''Call `act` on another thread once the main one waits in the wire's library.'''
    def watch():
        while not (LISTENING and LISTENING[0].wire_poller is not None):
            time.sleep(0.001)
        time.sleep(0.02)  # nothing tells that it is in there
        act()
    threading.Thread(target=watch).start()

def ready():
    when_it_leads(lambda: print('ready', flush=True))
"""


@pytest.fixture
def env() -> dict[str, str]:
    try:
        find_library()
    except TransportError as error:
        pytest.skip(str(error))
    return isolated_env(DDS)


def run(env: dict[str, str], body: str, number: signal.Signals | None = signal.SIGINT) -> tuple[int, str]:
    """Run HEAD and `body`, send the signal when it prints 'ready'; return the exit code and its output."""
    with Program(HEAD + body, env=env) as program:
        if number is not None:
            program.expect('ready')
            program.send_signal(number)
        return program.wait(10), program.output


CALL = 'node.create_client(Trigger, "nobody")'
WAITS = {
    'spin': 'rclpy.spin(node)',
    'spin_once': 'rclpy.spin_once(node)',
    'spin_until_future_complete': 'rclpy.spin_until_future_complete(node, rclpy.task.Future())',
    'wait_for_service': f'{CALL}.wait_for_service()',
    'sleep_for': 'node.get_clock().sleep_for(rclpy.duration.Duration(seconds=60))',
}


@pytest.mark.parametrize('wait', WAITS.values(), ids=WAITS.keys())
def test_ctrl_c_ends_a_wait_of_the_main_thread(env: dict[str, str], wait: str) -> None:
    body = f"""
node = begin()
ready()
begun = time.monotonic()
try:
    {wait}
except KeyboardInterrupt:
    print('interrupted', time.monotonic() - begun < 5)
"""
    code, output = run(env, body)
    assert code == 0, output
    assert 'interrupted True' in output


def test_ctrl_c_ends_a_blocking_call_that_nobody_answers(env: dict[str, str]) -> None:
    body = """
node = begin()
other = rclpy.create_node('mute')
from rclpy.executors import MultiThreadedExecutor
executor = MultiThreadedExecutor()
executor.add_node(other)
answer = threading.Event()
def never(request, response):
    print('ready', flush=True)
    answer.wait(20)
    return response
other.create_service(Trigger, 'mute', never)
threading.Thread(target=executor.spin, daemon=True).start()
client = node.create_client(Trigger, 'mute')
client.wait_for_service()
try:
    client.call(Trigger.Request())
except KeyboardInterrupt:
    print('interrupted')
answer.set()
"""
    code, output = run(env, body)
    assert code == 0, output
    assert 'interrupted' in output


@pytest.mark.parametrize('wait', ['rclpy.spin(node)', 'while rclpy.ok(): rclpy.spin_once(node)'])
def test_sigterm_ends_a_spin(env: dict[str, str], wait: str) -> None:
    body = f"""
node = begin()
ready()
try:
    {wait}
except rclpy.executors.ExternalShutdownException:
    print('ended')
"""
    code, output = run(env, body, signal.SIGTERM)
    assert code == 0, output
    assert 'ended' in output


def test_a_programs_own_alarm_rings_on_time_while_it_spins(env: dict[str, str]) -> None:
    body = """
node = begin()
late = []
def ring(number, frame):
    late.append(time.monotonic() - due)
    if len(late) == 5:
        rclpy.shutdown()
    else:
        arm()
def arm():
    global due
    due = time.monotonic() + 0.05
    signal.setitimer(signal.ITIMER_REAL, 0.05)
signal.signal(signal.SIGALRM, ring)
when_it_leads(lambda: os.kill(os.getpid(), signal.SIGALRM))
due = time.monotonic()
try:
    rclpy.spin(node)
except rclpy.executors.ExternalShutdownException:
    pass
print('rang', len(late), sorted(late)[2] < 0.1, late)
"""
    code, output = run(env, body, None)
    assert code == 0, output
    assert 'rang 5 True' in output


def test_what_a_programs_handler_raises_comes_out_of_spin_and_the_next_works(
    env: dict[str, str],
) -> None:
    body = """
node = begin()
class Late(Exception):
    pass
def ring(number, frame):
    raise Late
signal.signal(signal.SIGALRM, ring)
for _ in range(20):
    signal.setitimer(signal.ITIMER_REAL, 0.005)
    try:
        rclpy.spin(node)
    except Late:
        pass
node.create_service(Trigger, 'again', lambda request, response: response)
future = node.create_client(Trigger, 'again').call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future, timeout_sec=5)
print('answered', future.done())
"""
    code, output = run(env, body, None)
    assert code == 0, output
    assert 'answered True' in output


def test_without_a_listener_the_main_thread_sleeps_where_signals_find_it(env: dict[str, str]) -> None:
    body = """
node = begin(SignalHandlerOptions.NO)
try:
    threading.Timer(0.2, lambda: print('ready', flush=True)).start()
    rclpy.spin(node)
except KeyboardInterrupt:
    print('interrupted', rclpy.ok())
"""
    code, output = run(env, body)
    assert code == 0, output
    assert 'interrupted True' in output


@pytest.mark.parametrize('keeps', [True, False], ids=['and keeps them', 'and gave them back'])
def test_ctrl_c_is_heard_where_an_asyncio_loop_took_the_signals(env: dict[str, str], keeps: bool) -> None:
    body = f"""
node = begin()
async def main():
    loop = asyncio.get_running_loop()
    loop.add_signal_handler(signal.SIGUSR1, bool)
    if {keeps}:
        spin()
def spin():
    try:
        threading.Timer(0.2, lambda: print('ready', flush=True)).start()
        rclpy.spin(node)
    except KeyboardInterrupt:
        print('interrupted')
asyncio.run(main())
if not {keeps}:
    spin()
"""
    code, output = run(env, body)
    assert code == 0, output
    assert 'interrupted' in output


def test_a_signal_that_nobody_can_hear_ends_the_sleep_that_has_just_begun(env: dict[str, str]) -> None:
    body = """
node = begin()
async def main():
    asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, bool)
    begun = time.monotonic()
    try:
        threading.Timer(0.01, os.kill, (os.getpid(), signal.SIGINT)).start()
        rclpy.spin(node)
    except KeyboardInterrupt:
        print('interrupted', time.monotonic() - begun < 2)
asyncio.run(main())
"""
    code, output = run(env, body, None)
    assert code == 0, output
    assert 'interrupted True' in output


@pytest.mark.slow
def test_ctrl_c_ends_a_spin_fifty_times_of_fifty(env: dict[str, str]) -> None:
    body = """
node = begin()
for turn in range(50):
    when_it_leads(lambda: os.kill(os.getpid(), signal.SIGINT))
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        node.destroy_node()
        rclpy.try_shutdown()
        node = begin()
    else:
        sys.exit(f'turn {turn}: spin returned')
print('fifty')
"""
    code, output = run(env, body, None)
    assert code == 0, output
    assert 'fifty' in output


ELSEWHERE = """
def elsewhere(number):
    '''Another thread takes the signal: so the system's call that the main thread is in goes on.'''
    threading.Timer(0.2, lambda: signal.pthread_kill(threading.get_ident(), number)).start()
"""


def test_ctrl_c_that_the_main_thread_does_not_feel_ends_its_sleep(env: dict[str, str]) -> None:
    body = """
node = begin()
begun = time.monotonic()
try:
    elsewhere(signal.SIGINT)
    time.sleep(30)
except KeyboardInterrupt:
    print('interrupted', time.monotonic() - begun < 20)
rclpy.try_shutdown()
rclpy.uninstall_signal_handlers()
print('SIGURG as before:', signal.getsignal(signal.SIGURG) is signal.SIG_DFL)
"""
    code, output = run(env, ELSEWHERE + body, None)
    assert code == 0, output
    assert 'interrupted True' in output
    assert 'SIGURG as before: True' in output


def test_sigterm_that_the_main_thread_does_not_feel_lets_it_sleep_on(env: dict[str, str]) -> None:
    body = """
node = begin()
elsewhere(signal.SIGTERM)
begun = time.monotonic()
time.sleep(1)
print('slept', time.monotonic() - begun >= 1, 'ok', rclpy.ok())
"""
    code, output = run(env, ELSEWHERE + body, None)
    assert code == 0, output
    assert 'slept True ok False' in output


def test_a_programs_own_handler_of_sigurg_stays(env: dict[str, str]) -> None:
    body = """
own = lambda *_: print('urgent')
signal.signal(signal.SIGURG, own)
node = begin()
try:
    elsewhere(signal.SIGINT)
    time.sleep(1)
except KeyboardInterrupt:
    print('interrupted')
rclpy.uninstall_signal_handlers()
print(signal.getsignal(signal.SIGURG) is own)
"""
    code, output = run(env, ELSEWHERE + body, None)
    assert code == 0, output
    assert output.splitlines()[-2:] == ['interrupted', 'True']
