"""Threads that do the same thing at the same time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from helpers.patience import PATIENCE


def do_at_once(threads: int, body: Callable[[int], None]) -> None:
    """Run `body` on so many threads, with the numbers from 0 on, all at once. Raise the first error."""
    start = threading.Barrier(threads, timeout=PATIENCE)

    def begin(number: int) -> None:
        start.wait()
        body(number)

    with ThreadPoolExecutor(threads) as pool:
        for ended in [pool.submit(begin, number) for number in range(threads)]:
            ended.result(2 * PATIENCE)
