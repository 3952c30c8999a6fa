"""A worker of the fleet: it finds a robot for each mission, and asks the robot until the mission has ended.

pip install goalwire dbos
python worker.py postgresql://… NAME

Any number of workers may run. A worker that died goes on when it is started again under its NAME.
"""

import asyncio
import random
import sys
import uuid
from collections import Counter
from contextlib import suppress

from dbos import DBOS
from example_interfaces.action import Fibonacci
from leases import LEASE_S, Leases

import goalwire

FLEET = uuid.UUID('b3c9a2c4-3a55-4a0e-9c1d-6f4f3b6a1f10')
SKILLS = 'carry', 'lift'
AT_ONCE = 40
"""How many missions of a skill a worker has in hand: those of other skills do not wait behind them.

All workers together need as many as there are robots, or some robots have nothing to do.
"""

TURNS = {skill: asyncio.Lock() for skill in SKILLS}
"""Of the missions that wait for a robot only one of each skill looks for one, the first that came."""

SERVER_GONE = goalwire.NoServerError, goalwire.ServerLostError, goalwire.DeadlineError


class World:
    """The parts of this process that steps use; `main` sets it before the first step."""

    node: goalwire.Node
    leases: Leases


@DBOS.workflow(max_recovery_attempts=None)
async def deliver(mission: str, skill: str, order: int) -> list[str]:
    """Carry out a mission, and return the robot and how it ended. Its id in the engine is the mission's."""
    while True:
        robot = await find_robot(mission, skill)
        ended = await carry_out(mission, robot, skill, order)
        if ended:
            await free_robot(mission)
            return [robot, ended]


@DBOS.step()
async def find_robot(mission: str, skill: str) -> str:
    """Wait for a free robot that offers this action, and take it."""
    robot = await World.leases.take(mission, robots_with(skill))  # it may have one already
    if robot is not None:
        return robot
    async with TURNS[skill]:
        while True:
            robot = await World.leases.take(mission, robots_with(skill))
            if robot is not None:
                return robot
            await asyncio.sleep(1.0)


def robots_with(skill: str) -> list[str]:
    """Return the robots that are there and offer this action; those that can do little come first."""
    actions = [name.split('/')[1:] for name, _ in World.node.graph.served_actions()]
    skills = Counter(robot for robot, *action in actions if action[-1] in SKILLS)
    found = [robot for robot, *action in actions if action == [skill]]
    return sorted(found, key=lambda robot: (skills[robot], random.random()))  # noqa: S311


@DBOS.step()
async def carry_out(mission: str, robot: str, skill: str, order: int) -> str:
    """Ask the robot for the mission, again and again until its end is known; '' if the robot was not asked.

    The goal's id follows from the mission's, and the robot keeps it in its journal: asking twice is safe.
    """
    goal_id = uuid.uuid5(FLEET, mission)
    is_there = await has_server(f'/{robot}/{skill}')
    if not await World.leases.ask(mission, robot, is_there):
        return ''
    while True:
        # A new client each time: no client sends an id twice, but a robot that was restarted needs it again.
        client = World.node.action(Fibonacci, f'/{robot}/{skill}')
        try:
            return await follow(client, goal_id, order)
        except SERVER_GONE:
            pass  # the robot is away; when it is back, its journal has what it did
        except goalwire.GoalCanceled:
            return 'canceled'
        except goalwire.GoalAborted as error:
            # Without the mission's own sentence it is the robot's program that ended, and not the mission.
            if f'mission {goal_id.hex}' in str(error):
                return f'failed: {error}'
        finally:
            client.close()
        await asyncio.sleep(1.0)


async def follow(client, goal_id, order):
    """Send the goal, or follow it if the robot knows it, and wait for its end."""
    try:
        async with client.send(order=order, goal_id=goal_id, keep=True, timeout=10.0) as run:
            await run.result
    except (goalwire.GoalIdTaken, goalwire.GoalRefused):
        async with client.attach(goal_id) as run:
            await run.result
    return 'succeeded'


async def has_server(action):
    """Return whether the robot's action is there, after a quarter of a lease at most."""
    client = World.node.action(Fibonacci, action)
    try:
        await client.wait_for_server(timeout=LEASE_S / 4)
    except goalwire.NoServerError:
        return False
    finally:
        client.close()
    return True


@DBOS.step()
async def free_robot(mission: str) -> None:
    """Give the robot back."""
    await World.leases.end(mission)


async def main():
    url, name = sys.argv[1:]
    # The version is pinned: otherwise missions that were begun before a change of this file would not go on.
    DBOS(
        config={
            'name': 'fleet',
            'system_database_url': url,
            'executor_id': name,
            'application_version': '1',
        }
    )
    async with goalwire.Node('fleet', robots='*') as World.node:  # it need not know of the other workers
        World.leases = Leases(url)
        await World.leases.open()
        DBOS.launch()
        for skill in SKILLS:
            await DBOS.register_queue_async(skill, worker_concurrency=AT_ONCE)
        print('ready', flush=True)
        await asyncio.Event().wait()


if __name__ == '__main__':
    with suppress(KeyboardInterrupt):
        asyncio.run(main())
