"""Fleet: who is seen, and one goal for many robots."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.fleet import Robots
from helpers.loops import Play
from helpers.patience import PATIENCE
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

import goalwire
from goalwire.errors import MissionIdTaken
from goalwire.fleet import Fleet, GoalReport, RobotState

pytestmark = pytest.mark.also_on_dds

LATCHED = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)


def test_only_the_robots_of_the_pattern_are_seen(play: Play) -> None:
    async def scenario() -> None:
        async with Robots().serving('alpha', 'albert', 'beta'), Fleet('eye', robots='al*') as fleet:
            await fleet.wait_for('alpha', 'albert', timeout=PATIENCE)
            assert fleet.robots() == ['albert', 'alpha']
            assert fleet.robots('*a') == ['alpha']
            assert fleet.node.graph.nodes() == ['/albert/driver', '/alpha/driver', '/eye']
            assert '/beta/drive' not in dict(fleet.node.graph.actions())
            with pytest.raises(goalwire.NoRobotError, match="there is no robot 'alfa'; did you mean 'alpha'"):
                await fleet.state('alfa')

    play(scenario)


def test_a_robot_tells_its_battery_its_stop_and_its_goals(play: Play) -> None:
    async def scenario() -> None:
        robots = Robots()
        async with (
            robots.serving('alpha'),
            goalwire.Node('body', namespace='/alpha') as body,
            Fleet('eye') as fleet,
        ):
            battery = body.publisher(BatteryState, 'battery_state', qos=LATCHED)
            stopped = body.publisher(Bool, 'emergency_stopped', qos=LATCHED)
            battery.publish(percentage=0.25)
            stopped.publish(data=False)
            await fleet.wait_for('alpha', timeout=PATIENCE)
            drive = body.action(Fibonacci, 'drive')
            async with drive.send(order=0) as run:
                await robots.until(1)
                async with asyncio.timeout(PATIENCE):
                    while (found := await fleet.state('alpha')) != RobotState('alpha', 2, False, 0.25, 1):
                        assert found.robot == 'alpha'  # on DDS endpoints become known one by one
                assert found.word == 'busy'
                stopped.publish(data=True)
                assert (await fleet.state('alpha')).word == 'stopped'
                robots.hold.set()
                await run.result

    play(scenario)


def test_a_goal_for_many_robots_is_limited_and_each_has_a_report(play: Play) -> None:
    async def scenario() -> None:
        robots = Robots()
        names = [f'r{number}' for number in range(6)] + ['bad']
        async with robots.serving(*names), Fleet('dispatch') as fleet:
            await fleet.wait_for(*names, timeout=PATIENCE)
            reports = await fleet.send(Fibonacci, 'drive', order=7, parallel=2)
        found = {each.robot: each for each in reports}
        assert list(found) == sorted(names)
        assert found['bad'].status == 'ABORTED'
        assert 'an unlucky number' in found['bad'].why
        assert all(found[name].succeeded and found[name].result.sequence[0] == 7 for name in names[:-1])
        assert robots.by_robot == dict.fromkeys(names, 1)
        assert robots.most <= 2

    play(scenario)


def test_a_job_leaves_no_client_on_the_wire(play: Play) -> None:
    async def scenario() -> None:
        async with Robots().serving('alpha'), Fleet('dispatch') as fleet:
            await fleet.wait_for('alpha', timeout=PATIENCE)
            for _ in range(3):
                [report] = await fleet.send(Fibonacci, 'drive', order=1)
                assert report.succeeded
            changes = fleet.node.graph.changes()
            async with asyncio.timeout(PATIENCE):
                while any(name.startswith('/alpha/drive/') for name in clients_of(fleet)):
                    await anext(changes)
            changes.close()

    play(scenario)


def test_a_job_has_one_client_for_each_robot(play: Play, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    make = goalwire.Node.action

    def spy(node: goalwire.Node, action_type: Any, name: str) -> Any:
        made.append(name)
        return make(node, action_type, name)

    async def scenario() -> None:
        async with Robots().serving('alpha', 'beta'), Fleet('dispatch') as fleet:
            await fleet.wait_for('alpha', 'beta', timeout=PATIENCE)
            monkeypatch.setattr(goalwire.Node, 'action', spy)
            reports = await fleet.send(Fibonacci, 'drive', order=1)
            assert all(each.succeeded for each in reports)
        assert sorted(made) == ['/alpha/drive', '/beta/drive']

    play(scenario)


def clients_of(fleet: Fleet) -> list[str]:
    """The names of what the fleet's node has a client or a subscription of."""
    return [each.name for each in fleet.node.graph.endpoints() if each.node.name == 'dispatch']


def test_after_too_many_failures_no_further_goal_is_sent(play: Play) -> None:
    async def scenario() -> None:
        robots = Robots()
        names = [f'r{number}' for number in range(5)]
        async with robots.serving(*names), Fleet('dispatch') as fleet:
            await fleet.wait_for(*names, timeout=PATIENCE)
            reports = await fleet.send(Fibonacci, 'drive', order=13, parallel=1, max_failures=1)
        assert [each.status for each in reports] == ['ABORTED', 'ABORTED', 'NOT SENT', 'NOT SENT', 'NOT SENT']
        assert robots.executed.total() == 2

    play(scenario)


def test_a_repeated_job_runs_no_goal_twice(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        robots = Robots()
        journal = tmp_path / 'job.db'

        async def send(pattern: str) -> list[GoalReport]:
            async with Fleet('dispatch', robots=pattern) as fleet:
                await fleet.wait_for('alpha', timeout=PATIENCE)
                return await fleet.send(Fibonacci, 'drive', order=3, robots=pattern, journal=journal)

        async with robots.serving('alpha', 'albert'):
            [first] = await send('alpha')
            again = await send('al*')
        assert [each.robot for each in again if each.succeeded] == ['albert', 'alpha']
        assert again[1] == first
        assert robots.by_robot == {'alpha': 1, 'albert': 1}

    play(scenario)


def test_a_journal_belongs_to_one_goal(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        robots = Robots()
        async with robots.serving('alpha'), Fleet('dispatch') as fleet:
            await fleet.wait_for('alpha', timeout=PATIENCE)
            await fleet.send(Fibonacci, 'drive', order=3, journal=tmp_path / 'job.db')
            with pytest.raises(MissionIdTaken, match='belongs to another action, goal or timeout'):
                await fleet.send(Fibonacci, 'drive', order=4, journal=tmp_path / 'job.db')
        assert robots.executed.total() == 1

    play(scenario)


def test_whoever_cancels_the_task_cancels_every_goal(play: Play) -> None:
    async def scenario() -> None:
        robots = Robots()
        names = ['alpha', 'albert', 'beta']
        reports: dict[str, str] = {}
        async with robots.serving(*names), Fleet('dispatch') as fleet:
            await fleet.wait_for(*names, timeout=PATIENCE)
            sending = asyncio.ensure_future(
                fleet.send(
                    Fibonacci,
                    'drive',
                    order=0,
                    parallel=2,
                    on_change=lambda report: reports.update({report.robot: report.status}),
                )
            )
            await robots.until(2)
            sending.cancel()
            with pytest.raises(asyncio.CancelledError):
                await sending
        assert robots.canceled == 2
        assert reports == {'albert': 'CANCELED', 'alpha': 'CANCELED', 'beta': 'NOT SENT'}

    play(scenario)
