"""What sends the requests of one service client: a zenoh querier asks every complete queryable of its key.

Zenoh keeps about a kilobyte of each query until the query's time is over, even when it was answered at once
(measured with 1.10.2), and a querier has one time for all its queries. So requests with a time go through
queriers of their own, one for each power of two of seconds, declared at the first use. `session.get` takes
any time, but costs 5 µs more.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import zenoh

from goalwire.rules.time import S_TO_NS
from goalwire.transport.zenoh.context import taken_back, undeclare

UNTIMED_S: float | None = None
"""Of requests without a time; None: what the session's configuration says, ten minutes as under rmw_zenoh.
Less would end slow calls: a request may be answered late, and must not be sent twice."""

_MANNER: dict[str, Any] = {
    'target': zenoh.QueryTarget.ALL_COMPLETE,
    'consolidation': zenoh.ConsolidationMode.NONE,
    'congestion_control': zenoh.CongestionControl.BLOCK,
}


class Queriers:
    """The queriers of one key."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        """Declare the one for requests without a time."""
        self._declare: Callable[..., zenoh.Querier] = partial(session.declare_querier, key, **_MANNER)
        lasting = self._declare(timeout=UNTIMED_S)
        self._declared = {0: lasting}
        """By their time in s; 0 for requests without one."""
        self.get: Callable[..., object] = lasting.get
        """Send a request without a time."""

    def get_within(self, timeout_ns: int) -> Callable[..., object]:
        """Return what sends a request that zenoh gives up after `timeout_ns`, twice that (or 1 s) at most."""
        seconds = 1 << (timeout_ns // S_TO_NS).bit_length()
        querier = self._declared.get(seconds) or self._add(seconds)
        return querier.get

    def _add(self, seconds: int) -> zenoh.Querier:
        new = self._declare(timeout=float(seconds))
        kept = self._declared.setdefault(seconds, new)
        if kept is not new:
            undeclare(new)  # another thread was first
        return kept

    def undeclare(self) -> None:
        """Take them off the wire; who wants to send later gets RuntimeError."""
        self.get = self._declare = taken_back
        while self._declared:
            undeclare(self._declared.popitem()[1])
