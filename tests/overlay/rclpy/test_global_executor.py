"""The executor of rclpy.spin() is one for the whole program, whichever threads ask for it first."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import rclpy
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
