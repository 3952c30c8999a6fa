"""The recorder beside real publishers: every QoS, every message once, splits, snapshots, losses, failures."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from helpers.bags import contents, files_of
from helpers.loops import Play
from helpers.patience import PATIENCE
from helpers.wire import service_endpoint, topic_endpoint
from rosbag2_interfaces.srv import IsPaused, Pause, Resume, Snapshot, SplitBagfile
from std_msgs.msg import Int32, String
from tf2_msgs.msg import TFMessage

import goalwire
from goalwire.apps.bag.aborted_goals import snapshots_of_aborts
from goalwire.apps.bag.options import RecordOptions
from goalwire.apps.bag.recorder import DROPPED_KEY, Recorder
from goalwire.apps.bag.recorder_services import offer_services
from goalwire.apps.bag.selection import NONE, Names, Selection
from goalwire.entities.recorder_watch import SWITCH
from goalwire.errors import BagError
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy
from goalwire.transport.contract import EndpointKind, NodeName

EVERYTHING = Selection(Names(all=True), Names(all=True), Names(all=True))
NUMBERS = Selection(Names(some=frozenset({'/numbers'})))
BEST_EFFORT = QoS(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoS(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


async def until(condition: Callable[[], object]) -> None:
    async with asyncio.timeout(PATIENCE):
        while not condition():  # noqa: ASYNC110 - nothing tells of it
            await asyncio.sleep(0.005)


def decoded(path: Path, topic: str) -> list[Any]:
    with Reader(path) as bag:
        return [message.data for _, message in bag.decoded([topic])]


@pytest.mark.also_on_dds
def test_publishers_of_every_qos_are_recorded_once(play: Play, tmp_path: Path) -> None:
    """On one topic: what a latched one said before, and what a reliable and a best-effort one say then."""

    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            publishers = [
                talker.publisher(Int32, 'numbers', qos=qos) for qos in (LATCHED, QoS(depth=100), BEST_EFFORT)
            ]
            for value in range(5):
                publishers[0].publish(data=value)
            async with Recorder(node, Writer(tmp_path / 'bag'), NUMBERS) as recorder:
                for publisher in publishers:
                    await publisher.wait_for_subscribers(timeout=PATIENCE)
                await until(lambda: recorder.count >= 5)
                for value in range(5, 50):
                    for position, publisher in enumerate(publishers):
                        publisher.publish(data=1000 * position + value)
                    await asyncio.sleep(0)
                await until(lambda: recorder.count >= 5 + 45 * 3)

    play(scenario)
    expected = [*range(50), *range(1005, 1050), *range(2005, 2050)]
    assert Counter(decoded(tmp_path / 'bag', '/numbers')) == Counter(expected)


@pytest.mark.also_on_dds
def test_topics_that_come_later_are_recorded_and_in_order(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        bag = Writer(tmp_path / 'bag')
        async with goalwire.Node('recorder') as node, Recorder(node, bag, EVERYTHING) as recorder:
            assert recorder.count == 0
            async with goalwire.Node('talker') as talker:
                numbers = talker.publisher(Int32, 'numbers', qos=100)
                await numbers.wait_for_subscribers(timeout=PATIENCE)
                for value in range(100):
                    numbers.publish(data=value)
                last = talker.publisher(String, 'last')
                await last.wait_for_subscribers(timeout=PATIENCE)
                await asyncio.sleep(0)

    play(scenario)
    assert decoded(tmp_path / 'bag', '/numbers') == list(range(100))
    with Reader(tmp_path / 'bag') as bag:
        assert {'/numbers', '/last', '/parameter_events'} <= set(bag.counts)
        (qos,) = next(topic.qos for topic in bag.topics if topic.name == '/numbers')
        assert (qos.depth, qos.is_reliable) == (100, True)


def test_types_that_nobody_knows_are_recorded(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            raw = talker.raw_publisher(
                '/secret', 'never_seen_msgs/msg/Thing', type_hash='RIHS01_' + 'ab' * 32
            )
            async with Recorder(node, Writer(tmp_path / 'bag'), EVERYTHING) as recorder:
                await until(raw.subscribers)
                before = recorder.count
                raw.publish(b'\0\1\0\0what it means, nobody knows')
                await until(lambda: recorder.count > before)

    play(scenario)
    with Reader(tmp_path / 'bag') as bag:
        assert [m.data[4:] for m in bag.messages(['/secret'])] == [b'what it means, nobody knows']
        (topic,) = [each for each in bag.topics if each.name == '/secret']
        assert (topic.type_name, topic.type_hash) == ('never_seen_msgs/msg/Thing', 'RIHS01_' + 'ab' * 32)


def test_tf_static_is_in_every_file(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            static = talker.publisher(TFMessage, '/tf_static', qos=LATCHED)
            static.publish(TFMessage())
            numbers = talker.publisher(Int32, 'numbers', qos=100)
            selection = Selection(Names(all=True))
            async with Recorder(node, Writer(tmp_path / 'bag'), selection) as recorder:
                await numbers.wait_for_subscribers(timeout=PATIENCE)
                await static.wait_for_subscribers(timeout=PATIENCE)
                await until(lambda: recorder.count >= 1)
                for _ in range(3):
                    before = recorder.count
                    for value in range(10):
                        numbers.publish(data=value)
                    await until(lambda before=before: recorder.count >= before + 10)  # type: ignore[misc]
                    await recorder.split()

    play(scenario)
    assert len(files_of(tmp_path / 'bag')) == 4
    for file in files_of(tmp_path / 'bag'):
        with Reader(file) as bag:
            assert bag.counts['/tf_static'] == 1
    assert decoded(tmp_path / 'bag', '/numbers') == list(range(10)) * 3


def test_a_recorder_is_steered_by_services(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            numbers = talker.publisher(Int32, 'numbers', qos=100)
            end = talker.publisher(Int32, 'end')
            selection = Selection(Names(some=frozenset({'/numbers', '/end'})))
            async with Recorder(node, Writer(tmp_path / 'bag'), selection) as recorder:
                offer_services(recorder)
                await numbers.wait_for_subscribers(timeout=PATIENCE)
                await end.wait_for_subscribers(timeout=PATIENCE)
                numbers.publish(data=1)
                await until(lambda: recorder.count == 1)
                await talker.client(Pause, '/recorder/pause').call(timeout=PATIENCE)
                paused = await talker.client(IsPaused, '/recorder/is_paused').call(timeout=PATIENCE)
                assert paused.paused
                numbers.publish(data=2)
                heard = talker.subscription(Int32, 'numbers')  # comes after it, by the same way
                await heard.wait_for_publishers(timeout=PATIENCE)
                await talker.client(Resume, '/recorder/resume').call(timeout=PATIENCE)
                await talker.client(SplitBagfile, '/recorder/split_bagfile').call(timeout=PATIENCE)
                numbers.publish(data=3)
                await until(lambda: recorder.count == 2)
                refused = await talker.client(Snapshot, '/recorder/snapshot').call(timeout=PATIENCE)
                assert not refused.success

    play(scenario)
    assert decoded(tmp_path / 'bag', '/numbers') == [1, 3]
    assert len(files_of(tmp_path / 'bag')) == 2


def test_a_snapshot_has_the_last_messages(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            static = talker.publisher(TFMessage, '/tf_static', qos=LATCHED)
            static.publish(TFMessage())
            numbers = talker.publisher(Int32, 'numbers', qos=1000)
            options = RecordOptions(snapshot=True, cache_bytes=800)  # of Int32: a hundred
            async with Recorder(
                node, Writer(tmp_path / 'bag'), Selection(Names(all=True)), options
            ) as recorder:
                await numbers.wait_for_subscribers(timeout=PATIENCE)
                await static.wait_for_subscribers(timeout=PATIENCE)
                sent = 0
                for _ in range(2):
                    for _ in range(30):  # few at a time: the cache bounds what waits, too
                        before = recorder.count
                        for _ in range(10):
                            numbers.publish(data=sent)
                            sent += 1
                        await until(lambda before=before: recorder.count >= before + 10)  # type: ignore[misc]
                        await recorder.flush()
                    assert await recorder.snapshot() > 80

    play(scenario)
    first, second = (decoded(file, '/numbers') for file in files_of(tmp_path / 'bag'))
    assert first == list(range(300 - len(first), 300))
    assert second == list(range(600 - len(second), 600))
    for file in files_of(tmp_path / 'bag'):
        with Reader(file) as bag:
            assert bag.counts['/tf_static'] == 1


@pytest.mark.also_on_dds
def test_a_goal_that_is_aborted_writes_a_snapshot(play: Play, tmp_path: Path) -> None:
    """The one that was aborted before the recorder came writes none, and neither does one that succeeds."""

    async def run(goal: Any) -> Fibonacci.Result:
        if goal.request.order == 7:
            raise goalwire.GoalAborted('seven')
        return Fibonacci.Result(sequence=[goal.request.order])

    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            talker.action_server(Fibonacci, 'count', run)
            count = talker.action(Fibonacci, 'count')
            with pytest.raises(goalwire.GoalAborted):
                await count.call(order=7, timeout=PATIENCE)
            numbers = talker.publisher(Int32, 'numbers', qos=LATCHED)
            options = RecordOptions(snapshot=True)
            async with (
                Recorder(node, Writer(tmp_path / 'bag'), EVERYTHING, options) as recorder,
                snapshots_of_aborts(recorder),
            ):
                numbers.publish(data=1)
                await until(
                    lambda: '/numbers' in recorder.counts() and '/count/_action/status' in recorder.counts()
                )
                await count.call(order=3, timeout=PATIENCE)
                assert recorder.bag.count == 0
                with pytest.raises(goalwire.GoalAborted):
                    await count.call(order=7, timeout=PATIENCE)
                await until(lambda: recorder.bag.count)
                numbers.publish(data=2)

    play(scenario)
    assert decoded(tmp_path / 'bag', '/numbers') == [1]
    with Reader(tmp_path / 'bag') as bag:
        *_, (_, last) = bag.decoded(['/count/_action/status'])
    assert last.status_list[-1].status == GoalStatus.STATUS_ABORTED


def test_an_action_that_cannot_be_watched_is_told_and_the_others_are_watched(
    play: Play, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    async def fail(goal: Any) -> Fibonacci.Result:
        raise goalwire.GoalAborted('always')

    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            options = RecordOptions(snapshot=True)
            selection = Selection(Names(some=frozenset({'/numbers', '/count/_action/status'})))
            async with (
                Recorder(node, Writer(tmp_path / 'bag'), selection, options) as recorder,
                snapshots_of_aborts(recorder),
            ):
                stranger = talker.context.session.node(NodeName('stranger'))
                stranger.publisher(topic_endpoint(EndpointKind.PUBLISHER, '/lidar-1/_action/status'))
                numbers = talker.publisher(Int32, 'numbers', qos=LATCHED)
                numbers.publish(data=1)
                talker.action_server(Fibonacci, 'count', fail)
                with pytest.raises(goalwire.GoalAborted):
                    await talker.action(Fibonacci, 'count').call(order=7, timeout=PATIENCE)
                await until(lambda: recorder.bag.count)

    play(scenario)
    assert decoded(tmp_path / 'bag', '/numbers') == [1]
    told = capfd.readouterr().err
    assert told.count("an abort writes no snapshot: the goals of '/lidar-1' cannot be watched: Inv") == 1


@pytest.mark.also_on_dds
def test_calls_are_recorded_through_introspection(
    play: Play, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from goalwire.entities.service_introspection import ServiceIntrospectionState

    # Else the client, too, would tell of the call, if it has seen the recorder before it calls.
    monkeypatch.setenv(SWITCH, 'off')

    async def add(request: AddTwoInts.Request) -> AddTwoInts.Response:
        return AddTwoInts.Response(sum=request.a + request.b)

    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('recorder') as node:
            service = server.service(AddTwoInts, 'add', add)
            service._core.introspect(server.clock, QoS(), ServiceIntrospectionState.CONTENTS)
            selection = Selection(services=Names(some=frozenset({'/add'})))
            async with Recorder(node, Writer(tmp_path / 'bag'), selection) as recorder:
                await until(lambda: recorder.topics)
                await until(
                    lambda: [
                        e
                        for e in server.graph.endpoints()
                        if e.name == '/add/_service_event' and e.kind.value == 'subscription'
                    ]
                )
                client = server.client(AddTwoInts, 'add')
                await client.call(a=2, b=40, timeout=PATIENCE)
                await until(lambda: recorder.count >= 2)

    play(scenario)
    with Reader(tmp_path / 'bag') as bag:
        events = [event for _, event in bag.decoded()]
    # The client, whose introspection is off, tells the recorder of its call, too, if it has seen it by then.
    steps = [event for event in events if event.info.event_type in {1, 2}]
    assert [step.info.event_type for step in steps] == [1, 2]
    assert steps[0].request[0].b == 40
    assert steps[1].response[0].sum == 42


def test_a_disk_that_fails_ends_it_and_keeps_what_was_written(play: Play, tmp_path: Path) -> None:
    class FullDisk(Writer):
        """Fails at the fiftieth message, as a full disk does."""

        def put(self, message: Any) -> None:
            if self.count >= 50:
                raise BagError(f"the bag '{self.path}' cannot be written: No space left on device")
            super().put(message)

    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            numbers = talker.publisher(Int32, 'numbers', qos=100)
            async with Recorder(node, FullDisk(tmp_path / 'bag'), NUMBERS) as recorder:
                await numbers.wait_for_subscribers(timeout=PATIENCE)
                for value in range(80):
                    numbers.publish(data=value)
                async with asyncio.timeout(PATIENCE):
                    await recorder.wait()

    with pytest.raises(BagError, match='No space left'):
        play(scenario)
    assert decoded(tmp_path / 'bag', '/numbers') == list(range(50))
    with Reader(tmp_path / 'bag') as bag:
        (dropped,) = [json.loads(value) for key, value in bag.facts.custom_data if key == DROPPED_KEY]
    assert 0 < dropped['/numbers'] <= 30


def test_a_name_that_ros_forbids_is_told_and_what_comes_later_is_recorded(
    play: Play, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            stranger = talker.context.session.node(NodeName('stranger'))
            stranger.publisher(topic_endpoint(EndpointKind.PUBLISHER, '/lidar-1'))
            stranger.service(service_endpoint(EndpointKind.SERVICE, '/2nd'), lambda _: None)
            async with Recorder(node, Writer(tmp_path / 'bag'), EVERYTHING) as recorder:
                await until(lambda: recorder.topics)
                numbers = talker.publisher(Int32, 'numbers', qos=LATCHED)
                numbers.publish(data=1)
                await until(lambda: '/numbers' in recorder.counts())

    play(scenario)
    assert decoded(tmp_path / 'bag', '/numbers') == [1]
    told = capfd.readouterr().err
    assert told.count("'/lidar-1' is not recorded: ROS 2 forbids its name, topic name must not contain") == 1
    assert told.count("'/2nd' is not recorded: ROS 2 forbids its name") == 1


def test_messages_of_a_type_without_a_ros_name_are_recorded(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('recorder') as node:
            stranger = talker.context.session.node(NodeName('stranger'))
            endpoint = topic_endpoint(EndpointKind.PUBLISHER, '/scan', LATCHED, type_name='LidarScan')
            stranger.publisher(endpoint).publish(b'\0\1\0\0scan')
            async with Recorder(node, Writer(tmp_path / 'bag'), EVERYTHING) as recorder:
                await until(lambda: '/scan' in recorder.counts())

    play(scenario)
    assert [data for topic, _, data in contents(tmp_path / 'bag') if topic == '/scan'] == [b'\0\1\0\0scan']


def test_a_search_for_topics_that_fails_ends_the_recording(
    play: Play, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        async with (
            goalwire.Node('talker') as talker,
            goalwire.Node('recorder') as node,
            Recorder(node, Writer(tmp_path / 'bag'), EVERYTHING) as recorder,
        ):
            await until(lambda: recorder.topics)
            monkeypatch.setattr(Selection, 'wants', lambda *_: 1 / 0)
            talker.publisher(Int32, 'numbers')
            async with asyncio.timeout(PATIENCE):
                await recorder.wait()

    with pytest.raises(ZeroDivisionError):
        play(scenario)


def test_nothing_chosen_is_nothing_recorded(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('recorder') as node:
            recorder = Recorder(node, Writer(tmp_path / 'bag'), Selection(NONE))
            async with recorder:
                assert recorder.topics == []

    play(scenario)
    assert contents(tmp_path / 'bag') == []
