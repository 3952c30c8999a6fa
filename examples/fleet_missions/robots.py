"""Simulated robots: each has a runner of missions, a drive, and a file in which the drive counts.

python robots.py FOLDER FIRST LAST

Robot number N is the namespace /rN. All robots offer `carry`; those with an even number offer `lift`, too.
Kill the program and start it again with the same folder: the missions go on where they were.
"""

import asyncio
import sys
from contextlib import AsyncExitStack, suppress
from pathlib import Path

from example_interfaces.action import Fibonacci

import goalwire
from goalwire.missions import Runner, mission, offer


class Robot:
    """One robot. Its file has a line as a drive begins, and one as it ends."""

    def __init__(self, folder: Path, name: str) -> None:
        self.name = name
        self.log = folder / f'{name}.log'
        self.journal = folder / f'{name}.db'
        self.goals = folder / f'{name}.goals'

    async def serve(self, stack: AsyncExitStack) -> None:
        """Serve until the stack is closed."""
        # `robots`: the node has a session of its own, as on a robot of its own, and is told of this robot
        # alone. A robot that is told of all others and of each client of theirs is busy with nothing else.
        node = await stack.enter_async_context(
            goalwire.Node('body', namespace=f'/{self.name}', robots=self.name)
        )
        node.action_server(Fibonacci, 'drive', self.drive, journal=self.goals)
        missions = [mission(name=name, resume='auto')(self.deliver) for name in ('carry', 'lift')]
        runner = await stack.enter_async_context(
            Runner(node, self.journal, missions=missions, one_at_a_time=True)
        )
        for each in missions if int(self.name[1:]) % 2 == 0 else missions[:1]:
            offer(
                node,
                runner,
                each,
                Fibonacci,
                each.name,
                arguments=lambda goal: [goal.order],
                result=lambda order: Fibonacci.Result(sequence=[order]),
            )

    async def deliver(self, m, order):
        """The mission: one drive."""
        await m.action(Fibonacci, 'drive', if_lost=self.has_driven).call(order=order, timeout=300.0)
        return order

    async def drive(self, goal):
        """Drive for a second or two. A real robot moves here."""
        order = goal.request.order
        self.note(f'begin {order}')
        await asyncio.sleep(1.0 + order % 10 / 10)
        self.note(f'end {order}')
        return Fibonacci.Result(sequence=[order])

    async def has_driven(self, _node, goal):
        """Look at the world after the drive's own program has died."""
        return f'end {goal.order}' in self.log.read_text(encoding='utf-8').splitlines()

    def note(self, text):
        with self.log.open('a', encoding='utf-8') as file:
            file.write(text + '\n')


async def main():
    folder, first, last = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    async with AsyncExitStack() as stack:
        for number in range(first, last):
            await Robot(folder, f'r{number}').serve(stack)
        print('ready', flush=True)
        await asyncio.Event().wait()


if __name__ == '__main__':
    with suppress(KeyboardInterrupt):
        asyncio.run(main())
