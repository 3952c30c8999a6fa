"""Waiting for one message of a topic, on the calling thread."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, TypeVar

from goalwire.entities.subscription import SubscriptionCore
from goalwire.errors import RemoteError
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.future import Future, block_on
from goalwire.execution.monotonic import deadline_after

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.node import NodeCore
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Sample

MsgT = TypeVar('MsgT')


def wait_for_message(
    node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS, timeout_sec: float
) -> MsgT | None:
    """Return the next message, or None at the end of the time (negative: without limit) or of the context.

    It has a subscription of its own, which no executor serves: so it works inside callbacks, and beside
    threads that spin. Raises what making a subscription raises.
    """
    clock = node.context.shutdown_signal.clock
    subscription = _Awaited(node, msg_type, topic, qos)
    try:
        return subscription.receive(deadline_after(clock, timeout_sec))
    finally:
        subscription.destroy()


class _Awaited(SubscriptionCore[MsgT]):
    """Keeps what arrives for the thread that waits."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self._samples: deque[Sample] = deque(maxlen=max(qos.depth, 1))
        self._arrival: Future[None] = Future()
        super().__init__(node, msg_type, topic, _never_called, qos, ReentrantCallbackGroup())

    def _receiver(self) -> Callable[[Sample], None]:
        return self._deliver

    def _deliver(self, sample: Sample) -> None:
        self._samples.append(sample)
        self._arrival.set_result(None)

    def receive(self, deadline: int | None) -> MsgT | None:
        """Wait for a message that can be decoded; None at `deadline` (steady ns) or the context's end."""
        while block_on(self._arrival, deadline, self.node.context.shutdown_signal):
            self._arrival = Future()  # before looking: what comes now completes this one
            while self._samples:
                sample = self._samples.popleft()
                try:
                    message: MsgT = self._decode(sample.payload)
                except RemoteError as error:
                    self._reject(error)
                else:
                    return message
        return None


def _never_called(_message: object) -> None:
    raise AssertionError('messages that are waited for reach no executor')
