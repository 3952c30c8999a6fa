"""launch_testing.ready_aggregator: calls a function when all of several parts are ready."""

from __future__ import annotations

import threading
from collections.abc import Callable


class ReadyAggregator:
    """Calls a function when the last of several parts is ready. Each part says so by calling `ready_fn`."""

    def __init__(self, ready_fn: Callable[[], object], num_to_aggregate: int) -> None:
        self._call = ready_fn
        self._left = num_to_aggregate
        self._lock = threading.Lock()

    def ready_fn(self) -> None:
        with self._lock:
            self._left -= 1
            is_last = self._left == 0
        if is_last:
            self._call()
