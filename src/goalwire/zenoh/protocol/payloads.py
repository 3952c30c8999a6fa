"""Payloads that a link reads from shared memory."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from goalwire.zenoh.protocol.bodies import Payload, Resolve, refuse_slices
from goalwire.zenoh.protocol.channels import DATA_CHANNEL
from goalwire.zenoh.protocol.network import DEFAULT_QOS
from goalwire.zenoh.protocol.shared_memory import LinkMemory, Slices

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.handshake import Handshake
    from goalwire.zenoh.protocol.outgoing import Outgoing


class SharedPayloads:
    """Fetches payloads that the other side of a link has left in shared memory."""

    def __init__(self, refuse: Callable[[str, object], object]) -> None:
        """`refuse` counts a lost message and the reason."""
        self._refuse = refuse
        self._memory: LinkMemory | None = None
        self._qos = DEFAULT_QOS
        self._as_view = False

    def agree(self, handshake: Handshake, outgoing: Outgoing) -> None:
        """Share memory from now on, if both sides have agreed on it."""
        self._memory = outgoing.memory = handshake.make_memory(partial(outgoing.send, DATA_CHANNEL))

    def of(self, qos: int, *, as_view: bool = False) -> Resolve:
        """Return the function that fetches the payload of the current message, which has this QoS."""
        if self._memory is None:
            return refuse_slices
        self._qos, self._as_view = qos, as_view
        return self._fetch

    def _fetch(self, slices: Slices) -> Payload | None:
        """Return the payload; the message's priority names the counter that the read lowers."""
        memory = self._memory
        assert memory is not None
        payload = memory.take(slices, self._qos & 7, as_view=self._as_view)
        if payload is None:
            self._refuse('message in shared memory', 'its sender has reused the memory')
        return payload
