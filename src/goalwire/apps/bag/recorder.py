"""Records topics into a bag: a node of the asyncio API that takes serialized messages and decodes none."""

from __future__ import annotations

import asyncio
import json
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from goalwire.aio import Node
from goalwire.apps.bag.intake import Intake, Losses
from goalwire.apps.bag.options import RecordOptions
from goalwire.apps.bag.repeats import Repeats
from goalwire.apps.bag.selection import Selection, wants_calls
from goalwire.apps.bag.snapshot import Snapshot
from goalwire.apps.bag.topic_recording import Delivery, TopicRecording
from goalwire.entities.recorder_watch import POSTFIX_FOR_RECORDERS
from goalwire.entities.recorder_watch import QOS as EVENT_QOS
from goalwire.errors import BagError, peer_text
from goalwire.execution.asyncio.waiting import in_thread
from goalwire.logging import get_logger
from goalwire.observe.described_types import fetch_type
from goalwire.rosbag2.definitions import schema_of
from goalwire.rosbag2.model import SERVICE_EVENT, Schema
from goalwire.rosbag2.writer import Writer
from goalwire.rules.names.validation import InvalidName, validate_full_topic_name
from goalwire.transport.contract import EndpointKind, GraphEntity

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from goalwire.rules.qos import QoS

SETTLE_S = 1.0
"""Seconds to look for publishers if topics that appear later are not recorded."""
DROPPED_KEY, MISSED_KEY = 'goalwire.dropped', 'goalwire.missed'
"""Keys in the bag's custom data of the numbers of missing messages by topic, as JSON."""


class Recorder:
    """`async with Recorder(node, bag, selection) as recorder:` records until the block ends.

    The end of the block also closes the bag, even after an error. Only for the loop's thread.
    """

    def __init__(
        self, node: Node, bag: Writer, selection: Selection, options: RecordOptions | None = None
    ) -> None:
        """Take over the bag, which the recorder will close. `async with` begins the recording."""
        self.node = node
        self.bag = bag
        self.selection = selection
        self.options = options or RecordOptions()
        self._repeats = Repeats(dict(self.options.repeat))
        bag.heads = self._repeats.heads
        duration = int(self.options.snapshot_s * 1e9)
        self._snapshot = Snapshot(bag, self.options.cache_bytes, duration) if self.options.snapshot else None
        self._topics: dict[str, TopicRecording] = {}
        """The recording of each topic, by the topic's name on the wire."""
        self._searches: dict[asyncio.Task[None], Callable[[], None]] = {}
        """The searches for definitions of types, each with the function to call if nothing is found."""
        self._told: set[str] = set()
        self._failure: asyncio.Future[None]
        self._following: asyncio.Task[None]
        self._intake: Intake

    async def __aenter__(self) -> Self:
        loop = asyncio.get_running_loop()
        self._failure = loop.create_future()
        self._intake = Intake(
            self.bag if self._snapshot is None else self._snapshot,
            self.options.cache_bytes,
            self._repeats,
            failed=lambda error: loop.call_soon_threadsafe(self._fail, error),
        )
        self._intake.is_paused = self.options.paused
        self._following = asyncio.create_task(self._follow())
        self._following.add_done_callback(self._check_task)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._following.cancel()
        for search, define in list(self._searches.items()):
            search.cancel()
            define()
        for topic in self._topics.values():
            topic.close()
        closing = asyncio.ensure_future(in_thread(self._close))
        try:
            await asyncio.shield(closing)
        except asyncio.CancelledError:  # Even after a second Ctrl-C the file is closed properly.
            await closing
            raise
        if self._failure.done() and kind is None:
            await self._failure

    def _close(self) -> None:
        self._intake.close()
        self._note_losses()
        try:
            self.bag.close()
        except BagError as error:
            if not self._failure.done():
                self._failure.get_loop().call_soon_threadsafe(self._fail, error)

    def _fail(self, error: BaseException) -> None:
        if not self._failure.done():
            self._failure.set_exception(error)

    def _check_task(self, task: asyncio.Task[None]) -> None:
        """Let the recording fail if a task has failed: without it, topics would be missing in the bag."""
        if not task.cancelled() and (error := task.exception()) is not None:
            self._fail(error)

    async def wait(self) -> None:
        """Wait until recording fails, and raise its error: for example BagError on a full disk."""
        await asyncio.shield(self._failure)

    # -- counts and control ---------------------------------------------------------------------------------

    @property
    def topics(self) -> list[str]:
        """The topics that are recorded so far."""
        return list(dict.fromkeys(topic.delivery.topic for topic in self._topics.values()))

    @property
    def count(self) -> int:
        """The number of messages that were recorded so far."""
        return self._intake.count

    def types(self) -> dict[str, str]:
        """Return the types of the topics that are recorded so far."""
        return {topic.delivery.topic: topic.type_name for topic in self._topics.values()}

    def counts(self) -> Counter[str]:
        """Return how many messages of each topic were recorded so far."""
        return self._intake.counts()

    @property
    def byte_count(self) -> int:
        """The size of all messages that were recorded so far, in bytes."""
        return self._intake.byte_count

    @property
    def losses(self) -> Losses:
        """The numbers of messages that are missing in the bag, by topic."""
        return self._intake.losses

    @property
    def paused(self) -> bool:
        """True while arriving messages are left out."""
        return self._intake.is_paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._intake.is_paused = paused

    async def snapshot(self) -> int:
        """Write the messages in memory, and return their number.

        Raises BagError if the recorder was started without the option `snapshot`.
        """
        snapshot = self._snapshot
        if snapshot is None:
            raise BagError('the recorder was started without snapshots: use --snapshot-mode')
        return await self._on_writing_thread(snapshot.write)

    async def split(self) -> None:
        """Begin a new file."""
        await self._on_writing_thread(lambda: self.bag.split(self._now()))

    async def flush(self) -> None:
        """Write all messages that have arrived so far to the file."""
        await self._on_writing_thread(self.bag.flush)

    async def _on_writing_thread(self, job: Callable[[], int | None]) -> int:
        loop = asyncio.get_running_loop()
        done: asyncio.Future[int] = loop.create_future()

        def finish(result: int, error: BagError | None) -> None:
            if not done.done():
                done.set_result(result) if error is None else done.set_exception(error)

        def run() -> None:
            try:
                result, error = job() or 0, None
            except BagError as raised:
                result, error = 0, raised
            loop.call_soon_threadsafe(finish, result, error)

        self._intake.run(run)
        return await done

    def _now(self) -> int:
        return self.node.clock.now().nanoseconds

    def _note_losses(self) -> None:
        for key, lost in zip((DROPPED_KEY, MISSED_KEY), self.losses, strict=True):
            counts = {topic: count for topic, count in sorted(lost.items()) if count}
            if counts:
                self.bag.custom_data[key] = json.dumps(counts)

    # -- topics in the graph ------------------------------------------------------------------------------

    async def _follow(self) -> None:
        with self.node.graph.changes() as changes:
            self._look()
            if not self.options.discovery:
                await asyncio.sleep(SETTLE_S)
                self._look()
                return
            async for _ in changes:
                self._look()

    def _look(self) -> None:
        """Subscribe to the chosen topics that are new in the graph, and adapt to changed publishers."""
        there: dict[str, dict[EndpointKind, list[GraphEntity]]] = defaultdict(lambda: defaultdict(list))
        own, session = self.node.name, self.node.context.session.id
        for endpoint in self.node.graph.endpoints():
            if endpoint.session == session and endpoint.node.qualified == own:
                continue
            if endpoint.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}:
                there[endpoint.name][endpoint.kind].append(endpoint)
            else:
                self._ask_for_calls(endpoint)
        for name, endpoints in there.items():
            if not name.endswith(POSTFIX_FOR_RECORDERS):
                self._look_at(name, endpoints[EndpointKind.PUBLISHER], endpoints[EndpointKind.SUBSCRIPTION])
        for name, topic in self._topics.items():
            self._tell_of_others(topic, there[name][EndpointKind.PUBLISHER])

    def _look_at(self, name: str, publishers: list[GraphEntity], subscribers: list[GraphEntity]) -> None:
        known = self._topics.get(name)
        if known is not None:
            known.update(publishers)
            return
        if self.options.ignore_leaves and not subscribers:
            return
        found = publishers or (subscribers if self.options.unpublished else [])
        if found and self.selection.wants(name, found[0].type_name) and self._is_allowed(name):
            topic = self._topics[name] = self._recording(name, name, found[0].type_name, found[0].type_hash)
            topic.update(publishers)
            self._define_soon(topic, found[0].type_name, [each.qos.stated() for each in publishers])

    def _ask_for_calls(self, endpoint: GraphEntity) -> None:
        """If the calls of a server or client are chosen, ask the endpoint to publish its service events."""
        name, type_name = endpoint.name + SERVICE_EVENT, f'{endpoint.type_name}_Event'
        asked = endpoint.name + POSTFIX_FOR_RECORDERS
        if asked in self._topics or not wants_calls(self.selection, endpoint):
            return
        if self._is_allowed(endpoint.name):
            self._topics[asked] = self._recording(asked, name, type_name, '')
            self._define_soon(self._topics[asked], endpoint.type_name, [EVENT_QOS])

    def _is_allowed(self, name: str) -> bool:
        """Return whether ROS 2 allows a name, and tell of a forbidden one: no node can subscribe to it.

        Programs without ROS 2 announce such names, for example /lidar-1.
        """
        try:
            validate_full_topic_name(name)
        except InvalidName as error:
            self._tell(f"'{peer_text(name)}' is not recorded: ROS 2 forbids its name, {error.reason}")
            return False
        return True

    def _recording(self, wire_name: str, name: str, type_name: str, type_hash: str) -> TopicRecording:
        clock = self.node.clock if self.options.sim_time else None
        qos = dict(self.options.qos).get(name)
        delivery = Delivery(self._intake, name, clock)
        return TopicRecording(self.node, wire_name, type_name, type_hash, delivery, qos)

    def _define_soon(self, topic: TopicRecording, asked: str, qos: Iterable[QoS]) -> None:
        """Write the definition of a topic's type; if it is unknown, request the type `asked` from nodes."""
        if schema_of(topic.type_name)[1]:
            self._define(topic, qos)
            return

        async def find() -> None:
            await fetch_type(self.node, asked)
            self._define(topic, qos)

        search = asyncio.create_task(find())
        self._searches[search] = partial(self._define, topic, qos)
        search.add_done_callback(lambda done: self._searches.pop(done, None))
        search.add_done_callback(self._check_task)

    def _define(self, topic: TopicRecording, qos: Iterable[QoS]) -> None:
        """Add a topic to the bag, and begin to write its messages."""
        schema, known_hash = schema_of(topic.type_name)
        if topic.type_hash and known_hash and known_hash != topic.type_hash:
            self._tell(f"'{topic.name}' has another definition of {topic.type_name} than the one known here")
            schema = Schema()
        if not topic.type_hash:
            topic.type_hash = known_hash
        if topic.is_asked_for:
            if not known_hash:
                self._tell(f"calls of '{topic.name}' are not recorded: nobody tells what their type is")
                return
            topic.update(())
        name, type_name, type_hash = topic.delivery.topic, topic.type_name, topic.type_hash
        self._intake.run(
            lambda: self.bag.add_topic(name, type_name, type_hash=type_hash, schema=schema, qos=qos)
        )
        topic.delivery.open()

    def _tell_of_others(self, topic: TopicRecording, publishers: Iterable[GraphEntity]) -> None:
        for publisher in publishers:
            if publisher.type_name != topic.type_name:
                self._tell(
                    f"'{topic.name}' is recorded as {topic.type_name}; "
                    f'{publisher.node.qualified} publishes {publisher.type_name}, which is left out'
                )

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            get_logger('rosbag2_recorder').warning(text)
