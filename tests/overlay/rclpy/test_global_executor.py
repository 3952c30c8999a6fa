"""The executor of rclpy.spin() is one for the whole program, whichever threads ask for it first."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Event, Semaphore

import rclpy
from helpers.patience import PATIENCE
from rclpy.executors import Executor

THREADS = 8
ROUNDS = 30


def test_threads_that_ask_at_once_get_the_same_one() -> None:
    together = Barrier(THREADS)

    def ask() -> Executor:
        together.wait()
        return rclpy.get_global_executor()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            for _ in range(ROUNDS):
                rclpy.init()
                asked = [pool.submit(ask) for _ in range(THREADS)]
                assert len({id(each.result()) for each in asked}) == 1
                rclpy.shutdown()
    finally:
        sys.setswitchinterval(interval)


class Spins:
    """Counts the threads that begin to spin."""

    def __init__(self) -> None:
        self._begun = Semaphore(0)
        rclpy.get_default_context().shutdown_signal.spin_listeners.add(self)

    def on_spin(self) -> None:
        self._begun.release()

    def await_one(self) -> bool:
        return self._begun.acquire(timeout=PATIENCE)


def test_two_threads_spin_a_node_each() -> None:
    rclpy.init()
    nodes = [rclpy.create_node(name) for name in ('left', 'right')]
    called = [Event() for _ in nodes]
    spins = Spins()
    with ThreadPoolExecutor(len(nodes)) as pool:
        try:
            threads = [pool.submit(rclpy.spin, node) for node in nodes]
            assert all(spins.await_one() for _ in nodes)
            for node, each in zip(nodes, called, strict=True):
                node.create_guard_condition(each.set).trigger()
            assert all(each.wait(PATIENCE) for each in called)
        finally:
            rclpy.shutdown()
        for thread in threads:
            assert thread.exception(PATIENCE) is None
