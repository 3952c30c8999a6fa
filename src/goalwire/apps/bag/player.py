"""Plays a bag: publishes its messages in their order, at the times at which they were recorded."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Iterator
from contextlib import suppress

from rosgraph_msgs.msg import Clock

from goalwire.aio import Node, Publisher
from goalwire.aio.raw import RawPublisher
from goalwire.apps.bag.goal_requests import GoalRequests
from goalwire.apps.bag.options import PlayOptions
from goalwire.apps.bag.selection import action_of, service_of
from goalwire.apps.bag.service_requests import ServiceRequests
from goalwire.errors import BagError
from goalwire.records import replace
from goalwire.rosbag2.model import Message, Topic
from goalwire.rosbag2.reader import Reader
from goalwire.rules.qos import DEFAULT, QoS, ReliabilityPolicy
from goalwire.rules.time import Time

_S = 1_000_000_000
_PUBLISHED_AT_A_TIME = 100
"""At most this many messages are published before the event loop runs other tasks."""
DISCOVERY_S = 1.0
"""Seconds that a player waits at most until the subscriptions in the graph match its publishers."""


class Player:
    """`player = Player(node, bag)`, then `await player.play()`. Only the loop's thread may use it.

    `pause`, `resume`, `seek`, `step`, `stop` and `rate` control the playing. Times are the bag's, in ns.
    """

    def __init__(self, node: Node, bag: Reader, options: PlayOptions | None = None) -> None:
        """Make the publishers; raises BagError if nothing of the bag is chosen."""
        self.node = node
        self.bag = bag
        self.options = options = options or PlayOptions()
        self.topics = [topic for topic in bag.topics if self._plays(topic)]
        if not self.topics:
            raise BagError(f"the flags choose nothing of '{bag.path}'; see: ros2 bag info")
        self.start = bag.start + int(options.start_offset * _S)
        self.end = self._end()
        self.published = 0
        """How many messages were published."""
        self._rate = options.rate
        self._is_paused = options.paused
        self._is_stopped = self._is_playing = False
        self._steps = 0
        self._changed = asyncio.Event()
        self._position = self.start
        self._anchor = 0.0
        """The time on the loop's clock at which the bag's time was `_position`."""
        self._messages: Iterator[Message] = iter(())
        self._senders: dict[str, ServiceRequests | GoalRequests] = {}
        """By event topic: the sender of its recorded requests. The events themselves are not published."""
        self._requests: ServiceRequests | None = None
        self._goals: GoalRequests | None = None
        called = [t for t in self.topics if options.requests_from and service_of(t.name)]
        if called:
            self._requests = ServiceRequests(node, called, options.requests_from)
            self._senders |= {topic.name: self._requests for topic in called}
        acted = [t for t in self.topics if options.goals_from and action_of(t.name)]
        if acted:
            self._goals = GoalRequests(node, acted, options.goals_from)
            self._senders |= {topic.name: self._goals for topic in acted}
        self._publishers = {t.name: self._publisher(t) for t in self.topics if t.name not in self._senders}
        self._clock: Publisher[Clock] | None = None
        if options.clock_hz or options.clock_topics or options.clock_always:
            self._clock = node.publisher(Clock, '/clock', qos=1)

    def _plays(self, topic: Topic) -> bool:
        has_clock = self.options.clock_hz or self.options.clock_topics or self.options.clock_always
        if topic.name == '/clock' and has_clock:
            return False
        selection = self.options.selection
        return selection is None or selection.wants(topic.name, topic.type_name)

    def _end(self) -> int:
        ends = [self.bag.end]
        if self.options.duration is not None:
            ends.append(self.start + int(self.options.duration * _S))
        if self.options.until is not None:
            ends.append(self.options.until)
        return min(ends)

    def _publisher(self, topic: Topic) -> RawPublisher:
        qos = dict(self.options.qos).get(topic.name) or offered_by_all(topic.qos)
        name = dict(self.options.remaps).get(topic.name, topic.name)
        return self.node.raw_publisher(name, topic.type_name, type_hash=topic.type_hash, qos=qos)

    # -- steering --------------------------------------------------------------------------------------------

    @property
    def position(self) -> int:
        """The present position, as a time of the bag."""
        if self._is_paused or not self._is_playing:
            return self._position
        passed = asyncio.get_running_loop().time() - self._anchor
        return min(self._position + int(passed * self._rate * _S), max(self.end, self._position))

    @property
    def requested(self) -> int:
        """How many recorded requests were sent to servers."""
        return 0 if self._requests is None else self._requests.sent

    @property
    def goals_sent(self) -> int:
        """How many recorded goals were sent to servers."""
        return 0 if self._goals is None else self._goals.sent

    @property
    def rate(self) -> float:
        """The speed, as a multiple of the recorded one."""
        return self._rate

    @rate.setter
    def rate(self, rate: float) -> None:
        if not rate > 0:
            raise BagError(f'a bag cannot be played at the rate {rate}; it must be above 0')
        self._move_to(self.position)
        self._rate = rate

    @property
    def paused(self) -> bool:
        """True while the player is paused."""
        return self._is_paused

    def pause(self) -> None:
        """Stop the bag's time at the present position."""
        self._position = self.position
        self._is_paused = True
        self._changed.set()

    def resume(self) -> None:
        """Go on from the present position."""
        self._is_paused = False
        self._move_to(self._position)

    def seek(self, time: int) -> bool:
        """Go on at a time of the bag; for a time outside of the bag return False and do nothing."""
        if not self.bag.start <= time <= self.bag.end:
            return False
        self._messages = self._from(time)
        self._move_to(time)
        return True

    def step(self, count: int = 1) -> bool:
        """Publish the next `count` messages at once; if not paused, return False and do nothing."""
        if not self._is_paused:
            return False
        self._steps += count
        self._changed.set()
        return True

    def stop(self) -> None:
        """Stop playing."""
        self._is_stopped = True
        self._changed.set()

    def _move_to(self, time: int) -> None:
        self._position = time
        self._anchor = asyncio.get_running_loop().time()
        self._changed.set()

    # -- playing ---------------------------------------------------------------------------------------------

    async def play(self) -> None:
        """Play to the end, again and again with `loop`. Raises BagError if the bag is broken."""
        await self._wait_for_known_subscribers()
        senders = [each for each in (self._requests, self._goals) if each is not None]
        for sender in senders:
            await sender.wait_for_servers(DISCOVERY_S)
        ticking = asyncio.create_task(self._tick()) if self.options.clock_hz else None
        try:
            await self._play_rounds()
            for sender in senders:
                await sender.finish()
        finally:
            self._is_playing = False
            if ticking is not None:
                ticking.cancel()

    async def _play_rounds(self) -> None:
        while not self._is_stopped:
            if self.options.delay:
                await asyncio.sleep(self.options.delay)
            self._messages = self._from(self.start)
            self._is_playing = True
            self._move_to(self.start)
            await self._play_once()
            if not self.options.loop:
                return

    async def _play_once(self) -> None:
        in_a_row = 0
        while True:
            source = self._messages
            message = next(source, None)
            if message is None or not await self._is_due(message, source):
                if message is None or self._is_stopped:
                    return
                continue  # The position has changed meanwhile, so this message is not the next one.
            self._publish(message)
            in_a_row += 1
            if in_a_row % _PUBLISHED_AT_A_TIME == 0:
                await asyncio.sleep(0)

    def _from(self, time: int) -> Iterator[Message]:
        names = {topic.name for topic in self.topics}
        return self.bag.messages(names, time, self.end + 1)

    async def _is_due(self, message: Message, source: Iterator[Message]) -> bool:
        """Wait until a message is due; False if playing was stopped, or moved to another position,
        meanwhile.
        """
        loop = asyncio.get_running_loop()
        while not self._is_stopped and source is self._messages:
            self._changed.clear()
            if self._steps:
                self._steps -= 1
                self._position = message.time
                return True
            left: float | None = None
            if not self._is_paused:
                left = self._anchor + (message.time - self._position) / _S / self._rate - loop.time()
                if left <= 0:
                    return True
            with suppress(TimeoutError):
                async with asyncio.timeout(left):
                    await self._changed.wait()
        return False

    def _publish(self, message: Message) -> None:
        if self.options.clock_always or message.topic in self.options.clock_topics:
            self._publish_clock(message.time)
        sender = self._senders.get(message.topic)
        if sender is not None:
            sender.send(message)
            return
        self._publishers[message.topic].publish(message.data)
        self.published += 1

    def _publish_clock(self, time: int) -> None:
        assert self._clock is not None
        self._clock.publish(clock=Time(nanoseconds=time).to_msg())

    async def _tick(self) -> None:
        """Publish the bag's time at the set rate, also while the player is paused."""
        while True:
            self._publish_clock(self.position)
            await asyncio.sleep(1 / self.options.clock_hz)

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait until all reliable subscriptions have every published message; False if the time runs out.

        The call blocks its thread.
        """
        return all(each.wait_for_acknowledgements(timeout_ns) for each in self._publishers.values())

    async def _wait_for_known_subscribers(self) -> None:
        """Wait until the subscriptions in the graph match the publishers."""
        graph = self.node.graph
        try:
            async with asyncio.timeout(DISCOVERY_S):
                with graph.changes() as changes:
                    while not self._are_matched():
                        await anext(changes)
        except TimeoutError:
            return  # Endpoints with another type or QoS never match.

    def _are_matched(self) -> bool:
        waiting = {each.name for each in self.node.graph.endpoints() if each.kind.value == 'subscription'}
        return all(
            publisher.subscribers() for publisher in self._publishers.values() if publisher.name in waiting
        )


def offered_by_all(recorded: Iterable[QoS]) -> QoS:
    """Return a QoS that matches every subscription that the recorded publishers matched."""
    profiles = list(recorded)
    if not profiles:
        return DEFAULT
    chosen = profiles[0]
    for qos in profiles[1:]:
        chosen = replace(
            chosen,
            depth=max(chosen.depth, qos.depth),
            history=max(chosen.history, qos.history),
            reliability=ReliabilityPolicy.RELIABLE if qos.is_reliable else chosen.reliability,
            durability=qos.durability if qos.is_transient_local else chosen.durability,
        )
    return replace(chosen, depth=chosen.depth or DEFAULT.depth, lifespan_ns=0, deadline_ns=0)
