"""Calls of a service by any client, from its introspection events."""

from __future__ import annotations

from collections import OrderedDict
from time import monotonic
from typing import Any

from goalwire.observe.latencies import Latencies

KEPT = 1000
POSTFIX = '/_service_event'
STEPS = ('REQUEST_SENT', 'REQUEST_RECEIVED', 'RESPONSE_SENT', 'RESPONSE_RECEIVED')
"""The kinds of events, by the number in service_msgs/msg/ServiceEventInfo."""
_SENT, _RECEIVED, _ANSWERED, _CAME = range(len(STEPS))


class SeenCall:
    """One call: the times of its steps in s since 1970. Each time is by the clock of its publisher."""

    def __init__(self, client: str, number: int) -> None:
        self.client = client
        """The client's gid, in hexadecimal digits."""
        self.number = number
        """The client's sequence number of the call."""
        self.seen_at = monotonic()
        self.steps: dict[int, float] = {}
        self.request: Any = None
        """The message; None if the events have no contents."""
        self.response: Any = None

    @property
    def served_in(self) -> float | None:
        """The time in s from the request's arrival to the response, if the service tells both."""
        return self._between(_RECEIVED, _ANSWERED)

    @property
    def took(self) -> float | None:
        """The time in s from the request's sending to the response's arrival, if the client tells both."""
        return self._between(_SENT, _CAME)

    @property
    def state(self) -> str:
        """The name of its last step, in words."""
        return STEPS[max(self.steps)].replace('_', ' ').lower()

    def _between(self, first: int, last: int) -> float | None:
        if first in self.steps and last in self.steps:
            return max(0.0, self.steps[last] - self.steps[first])
        return None


class ServiceCalls:
    """The latest calls of one service."""

    def __init__(self) -> None:
        self._calls: OrderedDict[tuple[str, int], SeenCall] = OrderedDict()
        self.clients = Latencies()
        """From the request to the response, as clients tell them."""
        self.server = Latencies()
        """From the request's arrival to the response's sending, as the server tells them."""
        self.version = 0
        """A number that rises with each event."""

    def take(self, event: Any, _at: float = 0.0) -> None:
        """Note an event: a message of the service's type `Name_Event`."""
        info = event.info
        if not 0 <= info.event_type < len(STEPS):
            return
        key = bytes(info.client_gid).hex(), int(info.sequence_number)
        call = self._calls.get(key)
        if call is None:
            call = self._calls[key] = SeenCall(*key)
            while len(self._calls) > KEPT:
                self._calls.popitem(last=False)
        call.steps[int(info.event_type)] = info.stamp.sec + info.stamp.nanosec / 1e9
        if info.event_type == _CAME and call.took is not None:
            self.clients.note(call.took)
        if info.event_type == _ANSWERED and call.served_in is not None:
            self.server.note(call.served_in)
        if len(event.request):
            call.request = event.request[0]
        if len(event.response):
            call.response = event.response[0]
        self.version += 1

    def latest(self, most: int) -> list[SeenCall]:
        """Return the latest calls, the newest first."""
        return list(reversed(self._calls.values()))[:most]
