"""The loop that executors drive keeps to asyncio's public names, but for running inside another one."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
from asyncio import events, tasks

import pytest
from helpers.execution import SmallContext, SmallNode
from helpers.patience import PATIENCE

from goalwire.execution.asyncio import stepped_loop
from goalwire.execution.asyncio.fd_selector import FdSelector
from goalwire.execution.asyncio.stepped_loop import SteppedLoop
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import STEADY

WITHIN = """
import asyncio

import rclpy
from rclpy.task import Future

rclpy.init()
node = rclpy.create_node('within')
woken = Future()


async def callback():
    await asyncio.sleep(0)
    woken.set_result(asyncio.get_running_loop())


async def main():
    mine, my_task = asyncio.get_running_loop(), asyncio.current_task()
    guard = node.create_guard_condition(callback)
    guard.trigger()
    rclpy.spin_until_future_complete(node, woken, timeout_sec=10)
    assert woken.result() is not mine
    assert asyncio.get_running_loop() is mine and asyncio.current_task() is my_task


if {outside}:
    node.create_guard_condition(callback).trigger()
    rclpy.spin_until_future_complete(node, woken, timeout_sec=10)
    assert woken.done()
else:
    asyncio.run(main())
print('well')
"""


def run(*, outside: bool, stock: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {'GOALWIRE_STOCK_LOOP': stock, 'RMW_IMPLEMENTATION': 'goalwire_memory'}
    program = WITHIN.replace('{outside}', str(outside))
    return subprocess.run(
        [sys.executable, '-c', program],
        env=environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE * 5,
        check=False,
    )


def test_asyncio_still_offers_what_a_loop_within_a_loop_needs() -> None:
    assert {'_get_running_loop', '_set_running_loop'} <= set(events.__all__)
    assert {'_enter_task', '_leave_task'} <= set(tasks.__all__)
    assert stepped_loop.NESTS


def test_no_private_name_of_asyncios_loop_is_replaced() -> None:
    private = {name for name in vars(SteppedLoop) if name.startswith('_') and not name.startswith('__')}
    assert not [name for name in private if hasattr(asyncio.SelectorEventLoop, name)]


@pytest.mark.parametrize(('outside', 'stock'), [(True, '0'), (True, '1'), (False, '0')])
def test_a_coroutine_callback_runs(outside: bool, stock: str) -> None:
    result = run(outside=outside, stock=stock)
    assert result.stdout == 'well\n', result.stderr


def test_the_switch_turns_off_the_loop_within_a_loop_and_says_so() -> None:
    result = run(outside=False, stock='1')
    assert result.returncode == 1
    assert 'an asyncio loop runs on this thread' in result.stderr
    assert 'unset GOALWIRE_STOCK_LOOP' in result.stderr


def test_a_coroutine_callback_leaves_no_descriptor_to_be_watched(
    context: SmallContext, node: SmallNode
) -> None:
    """Else the thread that spins would sleep in a selector from then on, and no longer on the wire."""
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    done = Future[None]()

    async def callback() -> None:
        await asyncio.to_thread(bool)
        done.set_result(None)

    GuardCondition(callback, None, work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(done, PATIENCE)
    assert done.done()
    assert executor._fd_selector.watched == 0
    executor.shutdown()


@pytest.mark.skipif(sys.platform == 'win32', reason='asyncio takes no signals there')
@pytest.mark.parametrize('queued', [0, 5000])
def test_a_loop_that_is_to_hear_of_signals_watches_its_own_pipe(queued: int) -> None:
    wakes, fd_selector = list[None](), FdSelector(lambda: None)
    loop = SteppedLoop(fd_selector, STEADY, lambda: wakes.append(None))
    assert fd_selector.watched == 0
    for _ in range(queued):
        loop.call_soon_threadsafe(bool)
    came = list[str]()
    loop.add_signal_handler(signal.SIGUSR1, came.append, 'SIGUSR1')
    try:
        assert fd_selector.watched == 1
        os.kill(os.getpid(), signal.SIGUSR1)
        deadline = STEADY.now() + int(PATIENCE * 1e9)
        while not came:
            assert STEADY.now() < deadline, 'the signal is lost'
            assert fd_selector.wait(PATIENCE, bool), 'another thread waits there'
            assert wakes
            loop.step()
            loop.step()
    finally:
        loop.close()
        fd_selector.close()
    assert came == ['SIGUSR1']
