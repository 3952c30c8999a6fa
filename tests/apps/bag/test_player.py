"""The player: order, times, rate, pauses, seeking, clocks and names; in virtual time where times count."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.bags import MS, START, add_topics, expected, number, word, write_bag
from helpers.loops import Play
from helpers.patience import PATIENCE
from rosbag2_interfaces.srv import Pause, PlayNext, Resume, Seek, SetRate
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int32, String

import goalwire
from goalwire.apps.bag.options import PlayOptions
from goalwire.apps.bag.player import Player, offered_by_all
from goalwire.apps.bag.player_services import offer_services
from goalwire.apps.bag.selection import Names, Selection
from goalwire.errors import BagError
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy
from goalwire.testing import VirtualClock

ON_MEMORY = pytest.mark.parametrize('transport_name', ['goalwire_memory'])
NUMBERS_ONLY = Selection(Names(some=frozenset({'/numbers'})))


@pytest.fixture
def clock() -> Iterator[VirtualClock]:
    with VirtualClock() as clock:
        yield clock


def played(
    play: Play,
    path: Path,
    options: PlayOptions,
    steer: Callable[[Player], Coroutine[Any, Any, None]] | None = None,
    topic: str = '/numbers',
) -> list[tuple[float, int]]:
    """Play a bag; the numbers that were heard, each with the s that had passed."""
    heard: list[tuple[float, int]] = []

    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        with Reader(path) as bag:
            async with goalwire.Node('listener') as listener, goalwire.Node('player') as node:
                came: list[bytes] = []
                times: list[float] = []

                def deliver(sample: Any) -> None:
                    came.append(bytes(sample.payload))
                    times.append(loop.time())

                listener.raw_subscription(topic, 'std_msgs/msg/Int32', deliver, qos=1000)
                player = Player(node, bag, options)
                start = loop.time()
                steering = asyncio.create_task(steer(player)) if steer else None
                await player.play()
                if steering is not None:
                    await steering
                heard.extend(
                    (round(time - start, 6), int.from_bytes(data[4:8], 'little', signed=True))
                    for time, data in zip(times, came, strict=True)
                )

    play(scenario)
    return heard


def slow_bag(path: Path, count: int = 5) -> Path:
    """A number every two seconds."""
    with Writer(path) as bag:
        add_topics(bag)
        for value in range(count):
            bag.write('/numbers', number(value), START + value * 2000 * MS)
    return path


@pytest.mark.also_on_dds
def test_everything_is_published_in_order(play: Play, tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', max_bytes=700)
    heard: list[tuple[str, bytes]] = []

    async def scenario() -> None:
        async with goalwire.Node('listener') as listener, goalwire.Node('player') as node:
            for topic, kind in (('/numbers', 'Int32'), ('/words', 'String')):
                qos = QoS(depth=1000)
                listener.raw_subscription(
                    topic,
                    f'std_msgs/msg/{kind}',
                    lambda sample, topic=topic: heard.append((topic, bytes(sample.payload))),  # type: ignore[misc]
                    qos=qos,
                )
            with Reader(path) as bag:
                await Player(node, bag).play()
            async with asyncio.timeout(PATIENCE):
                while len(heard) < 110:  # noqa: ASYNC110 - nothing tells of it
                    await asyncio.sleep(0.005)

    play(scenario)
    for topic in ('/numbers', '/words'):
        wanted = [data for name, _, data in expected() if name == topic]
        found = [data for name, data in heard if name == topic]
        assert len(found) == len(wanted)
        for data, original in zip(found, wanted, strict=True):
            assert data.rstrip(b'\0') == original.rstrip(b'\0')  # DDS fills messages up with zeros


@ON_MEMORY
def test_times_are_those_of_the_recording(play: Play, clock: VirtualClock, tmp_path: Path) -> None:
    path = slow_bag(tmp_path / 'bag')
    assert played(play, path, PlayOptions()) == [(2.0 * value, value) for value in range(5)]
    twice = played(play, path, PlayOptions(rate=2.0))
    assert twice == [(1.0 * value, value) for value in range(5)]


@ON_MEMORY
@pytest.mark.parametrize(
    ('options', 'heard'),
    [
        (PlayOptions(start_offset=4), [(0.0, 2), (2.0, 3), (4.0, 4)]),
        (PlayOptions(start_offset=3, duration=1.5), [(1.0, 2)]),
        (PlayOptions(until=START + 2000 * MS), [(0.0, 0), (2.0, 1)]),
        (PlayOptions(delay=5, duration=0), [(5.0, 0)]),
        (PlayOptions(remaps=(('/numbers', '/other'),)), []),
    ],
    ids=str,
)
def test_a_part_is_played(
    play: Play, clock: VirtualClock, tmp_path: Path, options: PlayOptions, heard: list[tuple[float, int]]
) -> None:
    assert played(play, slow_bag(tmp_path / 'bag'), options) == heard


@ON_MEMORY
def test_another_name_is_published_to(play: Play, clock: VirtualClock, tmp_path: Path) -> None:
    options = PlayOptions(remaps=(('/numbers', '/other'),))
    heard = played(play, slow_bag(tmp_path / 'bag'), options, topic='/other')
    assert [value for _, value in heard] == [0, 1, 2, 3, 4]


@ON_MEMORY
def test_a_loop_begins_again_until_it_is_stopped(play: Play, clock: VirtualClock, tmp_path: Path) -> None:
    async def stop(player: Player) -> None:
        await asyncio.sleep(13.5)
        player.stop()

    heard = played(play, slow_bag(tmp_path / 'bag'), PlayOptions(loop=True), stop)
    assert heard == [(2.0 * v, v) for v in range(5)] + [(8 + 2.0 * v, v) for v in range(3)]


@ON_MEMORY
def test_a_player_is_steered(play: Play, clock: VirtualClock, tmp_path: Path) -> None:
    async def steer(player: Player) -> None:
        await asyncio.sleep(2.5)
        assert not player.step()
        player.pause()
        await asyncio.sleep(3)
        assert abs(player.position - START - 2500 * MS) < MS
        assert player.step()  # 2, at 5.5
        await asyncio.sleep(0.1)
        assert player.position == START + 4000 * MS
        player.rate = 4.0
        player.resume()  # 3 is due half a second later, at 6.1
        await asyncio.sleep(0.8)
        assert player.seek(START)  # 0, at 6.4
        assert not player.seek(START - 1)
        with pytest.raises(BagError, match='above 0'):
            player.rate = 0.0

    heard = played(play, slow_bag(tmp_path / 'bag'), PlayOptions(), steer)
    assert heard[:4] == [(0.0, 0), (2.0, 1), (5.5, 2), (6.1, 3)]
    assert heard[4:] == [(6.4 + 0.5 * value, value) for value in range(5)]


@ON_MEMORY
@pytest.mark.parametrize(
    ('options', 'told'),
    [
        (PlayOptions(clock_hz=2.0), [START + 500 * MS * n for n in range(17)]),
        (PlayOptions(clock_always=True), [START + 2000 * MS * n for n in range(5)]),
        (PlayOptions(clock_topics=frozenset({'/numbers'})), [START + 2000 * MS * n for n in range(5)]),
    ],
    ids=['hz', 'always', 'topics'],
)
def test_the_time_of_the_bag_is_published(
    play: Play, clock: VirtualClock, tmp_path: Path, options: PlayOptions, told: list[int]
) -> None:
    heard: list[int] = []

    async def scenario() -> None:
        async with goalwire.Node('listener') as listener, goalwire.Node('player') as node:
            times = listener.subscription(Clock, '/clock', qos=1000)
            with Reader(slow_bag(tmp_path / 'bag')) as bag:
                await Player(node, bag, options).play()
            times.close()
            heard.extend([t.clock.sec * 10**9 + round(t.clock.nanosec, -6) async for t in times])

    play(scenario)
    assert heard[: len(told)] == told[: len(heard)]
    assert len(heard) >= len(told) - 1


def test_a_player_has_services(play: Play, tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag')
    heard: list[int] = []

    async def scenario() -> None:
        async with goalwire.Node('listener') as listener, goalwire.Node('player') as node:
            numbers = listener.subscription(Int32, '/numbers', qos=1000)
            with Reader(path) as bag:
                player = Player(node, bag, PlayOptions(paused=True, selection=NUMBERS_ONLY))
                offer_services(player)
                playing = asyncio.create_task(player.play())

                async def ask(kind: Any, name: str, **fields: Any) -> Any:
                    return await listener.client(kind, f'/player/{name}').call(timeout=PATIENCE, **fields)

                assert (await ask(PlayNext, 'play_next')).success
                heard.append((await anext(numbers)).data)
                assert (await ask(SetRate, 'set_rate', rate=1000.0)).success
                assert not (await ask(SetRate, 'set_rate', rate=-1.0)).success
                time = Seek.Request()
                time.time.sec, time.time.nanosec = divmod(START + 90 * MS, 10**9)
                assert (await ask(Seek, 'seek', time=time.time)).success
                await ask(Pause, 'pause')
                await ask(Resume, 'resume')
                heard.extend([(await anext(numbers)).data for _ in range(10)])
                await playing

    play(scenario)
    assert heard == [0, *range(90, 100)]


def test_what_nobody_knows_is_played_and_what_is_latched_stays(play: Play, tmp_path: Path) -> None:
    with Writer(tmp_path / 'bag') as bag:
        latched = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        bag.add_topic('/secret', 'never_seen_msgs/msg/Thing', type_hash='RIHS01_' + 'ab' * 32, qos=[latched])
        bag.add_topic('/word', 'std_msgs/msg/String', qos=[latched])
        bag.write('/secret', b'\0\1\0\0abcd', START)
        bag.write('/word', word('late'), START)

    async def scenario() -> None:
        async with goalwire.Node('player') as node, goalwire.Node('listener') as listener:
            with Reader(tmp_path / 'bag') as bag:
                await Player(node, bag).play()
                words = listener.subscription(String, '/word', qos=latched)
                assert (await anext(words)).data == 'late'

    play(scenario)


def test_nothing_to_play_is_told(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('player') as node:
            with Reader(write_bag(tmp_path / 'bag')) as bag, pytest.raises(BagError, match='nothing of'):
                Player(node, bag, PlayOptions(selection=Selection()))

    play(scenario)


def test_one_qos_serves_all_who_were_served() -> None:
    best_effort = QoS(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    latched = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    chosen = offered_by_all([best_effort, latched])
    assert chosen.is_reliable
    assert chosen.is_transient_local
    assert chosen.depth == 5
    assert offered_by_all([best_effort]) == best_effort
    assert offered_by_all([]) == QoS()


def test_recorded_requests_are_sent_to_the_server(play: Play, tmp_path: Path) -> None:
    from example_interfaces.srv import AddTwoInts

    from goalwire.cdr.codec import encoder

    asked: list[tuple[int, int]] = []

    async def add(request: AddTwoInts.Request) -> AddTwoInts.Response:
        asked.append((request.a, request.b))
        return AddTwoInts.Response(sum=request.a + request.b)

    event = AddTwoInts.Event
    with Writer(tmp_path / 'bag') as bag:
        bag.add_topic('/add/_service_event', 'example_interfaces/srv/AddTwoInts_Event')
        for number_of_call in range(3):
            for step in range(4):  # sent, received, answered, the answer received
                message = event(request=[AddTwoInts.Request(a=number_of_call, b=step)] if step < 2 else [])
                message.info.event_type = step
                bag.write('/add/_service_event', encoder(event)(message), START + number_of_call)

    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('player') as node:
            server.service(AddTwoInts, 'add', add)
            for source in ('service_introspection', 'client_introspection'):
                with Reader(tmp_path / 'bag') as bag:
                    player = Player(node, bag, PlayOptions(requests_from=source))
                    await player.play()
                assert (player.requested, player.published) == (3, 0)

    play(scenario)
    assert sorted(asked[:3]) == [(0, 1), (1, 1), (2, 1)]
    assert sorted(asked[3:]) == [(0, 0), (1, 0), (2, 0)]
