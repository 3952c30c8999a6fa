"""Calls of a service as its introspection events tell them, whoever makes them."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from time import monotonic
from typing import Any

from goalwire.apps.console.types import as_data

KEPT = 100
POSTFIX = '/_service_event'
_STEPS = ('request sent', 'request received', 'response sent', 'response received')
"""By the number in service_msgs/msg/ServiceEventInfo."""
_SENT, _RECEIVED, _ANSWERED, _CAME = range(4)


class SeenCall:
    """One call: the times of its steps in s since 1970, each by the clock of who published it."""

    def __init__(self, client: str, number: int) -> None:
        self.client = client
        """The client's gid, in hexadecimal digits."""
        self.number = number
        """As the client counts its calls."""
        self.seen_at = monotonic()
        self.steps: dict[int, float] = {}
        self.request: Mapping[str, Any] | None = None
        """None where the events have no contents."""
        self.response: Mapping[str, Any] | None = None

    @property
    def served_in(self) -> float | None:
        """The time in s from the request's arrival to the response, where the service tells both."""
        return self._between(_RECEIVED, _ANSWERED)

    @property
    def took(self) -> float | None:
        """The time in s from the request's sending to the response's arrival, where the client tells both."""
        return self._between(_SENT, _CAME)

    @property
    def state(self) -> str:
        """Its last step."""
        return _STEPS[max(self.steps)]

    def _between(self, first: int, last: int) -> float | None:
        if first in self.steps and last in self.steps:
            return max(0.0, self.steps[last] - self.steps[first])
        return None


class ServiceEvents:
    """The latest calls of one service."""

    def __init__(self) -> None:
        self._calls: OrderedDict[tuple[str, int], SeenCall] = OrderedDict()
        self.version = 0
        """Rises with each event."""

    def take(self, event: Any, _at: float = 0.0) -> None:
        """Note an event: a message of the service's type `Name_Event`."""
        info = event.info
        if not 0 <= info.event_type < len(_STEPS):
            return
        key = bytes(info.client_gid).hex(), int(info.sequence_number)
        call = self._calls.get(key)
        if call is None:
            call = self._calls[key] = SeenCall(*key)
            while len(self._calls) > KEPT:
                self._calls.popitem(last=False)
        call.steps[int(info.event_type)] = info.stamp.sec + info.stamp.nanosec / 1e9
        if len(event.request):
            call.request = as_data(event.request[0])
        if len(event.response):
            call.response = as_data(event.response[0])
        self.version += 1

    @property
    def latest(self) -> list[SeenCall]:
        """The calls, the newest first."""
        return list(reversed(self._calls.values()))
