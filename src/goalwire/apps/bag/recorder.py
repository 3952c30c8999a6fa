"""Records topics into a bag: a node of the asyncio API that takes serialized messages and decodes none."""

from __future__ import annotations

import asyncio
import json
from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from goalwire.aio import Node
from goalwire.apps.bag.intake import Intake, Losses
from goalwire.apps.bag.options import RecordOptions
from goalwire.apps.bag.repeats import Repeats
from goalwire.apps.bag.selection import Selection
from goalwire.apps.bag.snapshot import Snapshot
from goalwire.errors import BagError
from goalwire.execution.asyncio.waiting import in_thread
from goalwire.logging import get_logger
from goalwire.rosbag2.definitions import schema_of
from goalwire.rosbag2.model import Schema
from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy
from goalwire.transport.contract import EndpointKind, GraphEntity, Sample

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from goalwire.aio.raw import RawSubscription

DEPTH = 1000
"""Of the recorder's subscriptions: history that is kept for it is not cut short."""
SETTLE_S = 1.0
"""How long publishers may take to be found if those that come later are not recorded."""
DROPPED_KEY, MISSED_KEY = 'goalwire.dropped', 'goalwire.missed'
"""Custom data of the bag: JSON, how many messages of each topic are not in it."""


class Recorder:
    """`async with Recorder(node, bag, selection) as recorder:` records until the block ends.

    The bag is closed then, in any case. Only for the loop's thread.
    """

    def __init__(
        self, node: Node, bag: Writer, selection: Selection, options: RecordOptions | None = None
    ) -> None:
        """Nothing is recorded yet. The bag belongs to the recorder from now on."""
        self.node = node
        self.bag = bag
        self.selection = selection
        self.options = options or RecordOptions()
        self._repeats = Repeats(dict(self.options.repeat))
        bag.heads = self._repeats.heads
        duration = int(self.options.snapshot_s * 1e9)
        self._snapshot = Snapshot(bag, self.options.cache_bytes, duration) if self.options.snapshot else None
        self._topics: dict[str, TopicRecording] = {}
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
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._following.cancel()
        for topic in self._topics.values():
            topic.close()
        closing = asyncio.ensure_future(in_thread(self._close))
        try:
            await asyncio.shield(closing)
        except asyncio.CancelledError:  # a second Ctrl-C: the file is closed in order all the same
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

    def _fail(self, error: BagError) -> None:
        if not self._failure.done():
            self._failure.set_exception(error)

    async def wait(self) -> None:
        """Wait until recording fails, as on a full disk; raises BagError then."""
        await asyncio.shield(self._failure)

    # -- what is asked of it --------------------------------------------------------------------------------

    @property
    def topics(self) -> list[str]:
        """The topics that are recorded by now."""
        return list(self._topics)

    @property
    def count(self) -> int:
        """How many messages were taken."""
        return self._intake.count

    @property
    def byte_count(self) -> int:
        """How many bytes the messages have that were taken."""
        return self._intake.byte_count

    @property
    def losses(self) -> Losses:
        """How many messages of each topic are not in the bag."""
        return self._intake.losses

    @property
    def paused(self) -> bool:
        """Whether what comes is left out."""
        return self._intake.is_paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._intake.is_paused = paused

    async def snapshot(self) -> int:
        """Write what is in memory, and return how many messages; raises BagError without `snapshot`."""
        snapshot = self._snapshot
        if snapshot is None:
            raise BagError('the recorder was started without snapshots: use --snapshot-mode')
        return await self._on_writing_thread(snapshot.write)

    async def split(self) -> None:
        """Begin a new file."""
        await self._on_writing_thread(lambda: self.bag.split(self._now()))

    async def flush(self) -> None:
        """Have everything in the file that has come by now."""
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

    # -- who is there -------------------------------------------------------------------------------------

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
        """Subscribe to what is wanted and has come; a change of the graph tells of everything at once."""
        there: dict[str, dict[EndpointKind, list[GraphEntity]]] = defaultdict(lambda: defaultdict(list))
        own, session = self.node.name, self.node.context.session.id
        for endpoint in self.node.graph.endpoints():
            is_own = endpoint.session == session and endpoint.node.qualified == own
            if endpoint.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION} and not is_own:
                there[endpoint.name][endpoint.kind].append(endpoint)
        for name, endpoints in there.items():
            publishers = endpoints[EndpointKind.PUBLISHER]
            subscribers = endpoints[EndpointKind.SUBSCRIPTION]
            known = self._topics.get(name)
            if known is not None:
                known.update(publishers)
                continue
            if self.options.ignore_leaves and not subscribers:
                continue
            found = publishers or (subscribers if self.options.unpublished else [])
            if found and self.selection.wants(name, found[0].type_name):
                self._begin(name, found[0], publishers)
        for name, topic in self._topics.items():
            self._tell_of_others(topic, there[name][EndpointKind.PUBLISHER])

    def _begin(self, name: str, first: GraphEntity, publishers: list[GraphEntity]) -> None:
        schema, known_hash = schema_of(first.type_name)
        type_hash = first.type_hash or known_hash
        if known_hash and known_hash != type_hash:
            self._tell(f"'{name}' has another definition of {first.type_name} than the one known here")
            schema = Schema()
        qos = [publisher.qos.stated() for publisher in publishers]
        type_name = first.type_name
        self._intake.run(
            lambda: self.bag.add_topic(name, type_name, type_hash=type_hash, schema=schema, qos=qos)
        )
        topic = TopicRecording(self, name, type_name, type_hash, dict(self.options.qos).get(name))
        self._topics[name] = topic
        topic.update(publishers)

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

    def deliverer(self, topic: str, accepts: Callable[[bytes], bool] | None) -> Callable[[Sample], None]:
        """Return what takes the messages of a topic, those of publishers that `accepts(gid)` says."""
        put = self._intake.put
        clock = self.node.clock if self.options.sim_time else None

        def deliver(sample: Sample) -> None:
            if accepts is None or accepts(sample.gid):
                time = sample.received_timestamp if clock is None else clock.now().nanoseconds
                if time:  # simulated time is 0 before the first /clock
                    put(topic, sample, time)

        return deliver


_Class = tuple[bool, bool]
"""Whether publishers are reliable, and whether they keep history."""


class TopicRecording:
    """The subscriptions of one topic.

    If the wire keeps endpoints apart whose QoS do not go together, no single subscription serves all
    publishers as well as they offer: one that takes best effort loses messages of reliable publishers, one
    that is reliable hears nothing of the others. So there is a subscription for each class of publishers, and
    each takes messages of its own class alone. On other wires reliability is the publisher's business, and
    only those with history are a class of their own.
    """

    def __init__(
        self, recorder: Recorder, name: str, type_name: str, type_hash: str, qos: QoS | None
    ) -> None:
        self.name = name
        self.type_name = type_name
        self._recorder = recorder
        self._type_hash = type_hash
        self._qos = qos
        self._owners: dict[bytes, _Class] = {}
        self._subscriptions: dict[_Class, RawSubscription] = {}

    def update(self, publishers: Iterable[GraphEntity]) -> None:
        """Subscribe as these publishers need it."""
        fitting = [each for each in publishers if each.type_name == self.type_name]
        if self._qos is not None:
            if not self._subscriptions:
                self._subscribe((True, True), self._qos, None)
            return
        enforces_qos = self._recorder.node.context.session.enforces_qos
        classes: dict[_Class, None] = {}
        for publisher in fitting:
            offered = publisher.qos.stated()
            found = offered.is_reliable and enforces_qos, offered.is_transient_local
            self._owners[publisher.gid] = found
            classes[found] = None
        for found in classes or {(enforces_qos, False): None}:
            if found not in self._subscriptions:
                self._subscribe(found, _qos_for(found), self._acceptor(found))

    def _acceptor(self, own: _Class) -> Callable[[bytes], bool]:
        owners = self._owners
        other = next(iter(self._subscriptions), own)
        """Takes the messages of publishers that the graph does not show: the first subscription."""
        return lambda gid: owners.get(gid, other) == own

    def _subscribe(self, kind: _Class, qos: QoS, accepts: Callable[[bytes], bool] | None) -> None:
        deliver = self._recorder.deliverer(self.name, accepts)
        self._subscriptions[kind] = self._recorder.node.raw_subscription(
            self.name, self.type_name, deliver, type_hash=self._type_hash, qos=qos
        )

    def close(self) -> None:
        """Subscribe to nothing any more."""
        for subscription in self._subscriptions.values():
            subscription.close()


def _qos_for(kind: _Class) -> QoS:
    is_reliable, has_history = kind
    return QoS(
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if has_history else DurabilityPolicy.VOLATILE,
    )
