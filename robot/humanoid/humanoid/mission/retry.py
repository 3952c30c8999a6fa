"""Retries calls that get no answer, with growing pauses, within one deadline."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar('T')


class NoAnswer(Exception):
    """A call did not end in time; the text names the service or action, and the time waited."""


@dataclass(frozen=True)
class Backoff:
    """Pauses between attempts, in s: `first`, then each `factor` times the one before, at most `longest`."""

    first: float = 0.2
    factor: float = 2.0
    longest: float = 1.0

    def pause(self, attempt: int) -> float:
        """Return the pause after attempt number `attempt`, counted from 1."""
        return min(self.first * self.factor ** (attempt - 1), self.longest)


def retry(
    attempt: Callable[[float], T],
    *,
    attempt_timeout: float,
    timeout: float,
    backoff: Backoff,
    on_retry: Callable[[int, float, NoAnswer], None],
    sleep: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> tuple[T, int]:
    """Call `attempt(seconds)` until it answers; return the answer and the number of attempts.

    Only for requests that may safely be made twice. Each attempt may take `attempt_timeout` s; all attempts
    and pauses together may take `timeout` s. `on_retry(attempt, pause, why)` is called before each retry.
    Raises the last attempt's NoAnswer.
    """
    deadline = clock() + timeout
    number = 1
    while True:
        try:
            return attempt(min(attempt_timeout, max(deadline - clock(), 0.0))), number
        except NoAnswer as why:
            pause = backoff.pause(number)
            if clock() + pause >= deadline:
                raise NoAnswer(f'{why} (attempt {number}, none left within {timeout:g} s)') from why
            on_retry(number, pause, why)
            sleep(pause)
        number += 1
