"""Collects the calls that any client makes to a service, from the service's introspection events."""

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
    """One call of a service. The times of its steps are in s since 1970, by the clock of the events'
    publisher.
    """

    def __init__(self, client: str, number: int) -> None:
        self.client = client
        """The gid of the calling client, in hexadecimal digits."""
        self.number = number
        """The sequence number that the client gave the call."""
        self.seen_at = monotonic()
        self.steps: dict[int, float] = {}
        self.request: Any = None
        """The request message; None if the introspection events have no contents."""
        self.response: Any = None

    @property
    def served_in(self) -> float | None:
        """The time in s from the request's arrival to the response, if events of the service report both."""
        return self._between(_RECEIVED, _ANSWERED)

    @property
    def took(self) -> float | None:
        """The time in s from the request's sending to the response's arrival, if events of the client report
        both.
        """
        return self._between(_SENT, _CAME)

    @property
    def state(self) -> str:
        """The name of the call's last step, in lower case."""
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
        """The durations from the request to the response, as reported by clients' events."""
        self.server = Latencies()
        """The durations from the request's arrival to the response's sending, as reported by the server's
        events.
        """
        self.version = 0
        """A number that rises with each event."""

    def take(self, event: Any, _at: float = 0.0) -> None:
        """Note an introspection event: a message of the service's type `Name_Event`."""
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
