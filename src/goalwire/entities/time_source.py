"""Simulated time: while `use_sim_time` is true, messages on /clock set the ROS clocks of a node."""

from __future__ import annotations

from functools import partial
from threading import Lock
from typing import TYPE_CHECKING
from weakref import ReferenceType, ref

from goalwire.entities.subscription import SubscriptionCore
from goalwire.errors import RemoteError
from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup
from goalwire.execution.current_callback import why_it_cannot_answer
from goalwire.rules.qos import QoS, ReliabilityPolicy
from goalwire.rules.time import S_TO_NS, ClockType, Time

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosgraph_msgs.msg import Clock as ClockMessage

    from goalwire.entities.node import NodeCore
    from goalwire.entities.parameters.node_parameters import NodeParameters
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.time.clock import ROSClock
    from goalwire.rules.parameters import Parameter
    from goalwire.transport.contract import Sample

CLOCK_TOPIC = '/clock'
CLOCK_QOS = QoS(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
USE_SIM_TIME_NAME = 'use_sim_time'


class TimeSourceCore:
    """Sets the attached clocks, and switches all of them between /clock and system time."""

    def __init__(self) -> None:
        self._clocks: list[ROSClock] = []
        self._last = Time(clock_type=ClockType.ROS_TIME)
        self._active = False
        self.subscription: ClockSubscription | None = None

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clocks follow /clock."""
        return self._active

    @ros_time_is_active.setter
    def ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._active:
            return
        self._active = enabled
        for clock in self._clocks:
            clock.switch_override(enabled)
        if enabled:
            self._subscribe()
        else:
            self._unsubscribe()

    def _subscribe(self) -> None:
        """Begin to listen to /clock. The node's API calls this."""

    def _unsubscribe(self) -> None:
        """Stop listening to /clock."""

    def attach_clock(self, clock: ROSClock) -> None:
        """Set `clock`, too, from now on. It begins with the last time that came on /clock."""
        clock.set_ros_time_override(self._last)
        clock.switch_override(self._active)
        if clock not in self._clocks:
            self._clocks.append(clock)
            clock.before_sleep.append(self.catch_up)

    def _follow(self, parameters: Sequence[Parameter]) -> None:
        """Apply the new value of `use_sim_time`. The node calls this after parameters were set."""
        for parameter in parameters:
            if parameter.name == USE_SIM_TIME_NAME and isinstance(parameter.value, bool):
                self.ros_time_is_active = parameter.value

    def catch_up(self) -> bool:
        """Set the clocks on a thread that is about to sleep; True if there was a message to set them by."""
        return self.subscription is not None and self.subscription.catch_up()

    def wake_sleepers(self) -> None:
        """Wake sleeping threads: a message waits for an executor, which one of these threads may hold up."""
        for clock in self._clocks:
            clock.wake_sleepers()

    def clock_callback(self, msg: ClockMessage) -> None:
        """Set the clocks to the time of a message; jump callbacks are called in here."""
        self._last = time = Time.from_msg(msg.clock)
        for clock in self._clocks:
            clock.set_ros_time_override(time)

    def advance_quietly(self, time_ns: int) -> bool:
        """Set the clocks unless that would call a jump callback; return whether they were set."""
        time = Time(nanoseconds=time_ns, clock_type=ClockType.ROS_TIME)
        if not all(clock.advance_quietly(time_ns) for clock in self._clocks):
            return False
        self._last = time
        return True


class NodeTimeSource(TimeSourceCore):
    """Sets a node's clock from /clock, under its parameter `use_sim_time`."""

    def __init__(self, node: NodeParameters) -> None:
        super().__init__()
        self._core = node.handle
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        self.attach_clock(self._core.clock)
        self._follow([node.get_parameter(USE_SIM_TIME_NAME)])
        node.add_post_set_parameters_callback(self._follow)

    def _subscribe(self) -> None:
        self.subscription = ClockSubscription(self._core, MutuallyExclusiveCallbackGroup(), self)

    def _unsubscribe(self) -> None:
        subscription, self.subscription = self.subscription, None
        if subscription is not None:
            subscription.destroy()


class ClockSubscription(SubscriptionCore['ClockMessage']):
    """A subscription to /clock. Time must go on while the executor is busy: a callback may sleep until later.

    So a message sets the clocks on the thread that brings it. But if it would call jump callbacks, the
    executor handles it and later messages until these callbacks have run. Only the newest message waits
    there. A sleeping thread that holds up the executor or the callback group takes this message itself.
    """

    def __init__(self, node: NodeCore, group: CallbackGroup, source: TimeSourceCore) -> None:
        from rosgraph_msgs.msg import Clock as ClockMessage

        self._source = source
        self._group = group
        self._order = Lock()
        self._queued = False
        super().__init__(node, ClockMessage, CLOCK_TOPIC, source.clock_callback, CLOCK_QOS, group)

    def _receiver(self) -> Callable[[Sample], None]:
        return partial(ClockSubscription._deliver, ref(self))

    @staticmethod
    def _deliver(reference: ReferenceType[ClockSubscription], sample: Sample) -> None:
        # hot path: a static method with a weak reference, so that the wire neither keeps the subscription
        # alive nor makes two calls.
        self = reference()
        if self is None:
            return
        try:
            time_ns = self._time_of(sample)
        except RemoteError as error:
            self._reject(error)
            return
        with self._order:
            if not self._queued and self._source.advance_quietly(time_ns):
                return
            self._queued = True
            self.event_queue.deliver(sample)
        self._source.wake_sleepers()

    def catch_up(self) -> bool:
        """Take the waiting message if no executor can while the calling thread sleeps; True if so."""
        work_queue = self.node.work_queue
        if not self._queued or (
            work_queue.attached and why_it_cannot_answer(work_queue, self._group) is None
        ):
            return False
        sample = self.event_queue.take()
        if sample is None:
            return False
        self._handle(sample)
        return True

    def _time_of(self, sample: Sample) -> int:
        stamp = self.support.decode(sample.payload).clock
        if stamp.sec < 0:
            raise RemoteError(f'no clock shows a time before 0, and {stamp.sec} s was sent')
        time_ns: int = stamp.sec * S_TO_NS + stamp.nanosec
        return time_ns

    def _handle(self, sample: Sample) -> object:
        try:
            return super()._handle(sample)
        finally:
            with self._order:
                self._queued = len(self.event_queue) > 0
