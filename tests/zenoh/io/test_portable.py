"""Sessions of ours on a system without epoll, eventfd and sendmsg, as real programs: macOS and Windows."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import programs_in

WITHOUT = """
import atexit, os, select, selectors, socket, sys
from importlib import reload

for module, name in ({names}):
    delattr(module, name)
reload(selectors)
{more}

def tell():
    pollers = sys.modules.get('goalwire.concurrency.poller')
    if pollers is not None and 'goalwire.transport.zenoh.eclipse_wire' not in sys.modules:
        print('waited with', selectors.DefaultSelector.__name__, pollers.IS_PORTABLE)

atexit.register(tell)
"""
"""A sitecustomize.py: what it takes away is gone before anything else of a program is imported."""
LINUX_ALONE = "(select, 'epoll'), (os, 'eventfd')"
SYSTEMS = {
    'PollSelector': WITHOUT.format(names=LINUX_ALONE, more=''),
    'SelectSelector': WITHOUT.format(
        names=f"{LINUX_ALONE}, (select, 'poll')",
        more='socket.socket.sendmsg = property(lambda _: getattr(_, "no_sendmsg"))',
    ),
}


@pytest.fixture(params=list(SYSTEMS))
def selector(request: pytest.FixtureRequest) -> str:
    """The selector that programs on such a system wait with."""
    name: str = request.param
    return name


@pytest.fixture
def world(selector: str, tmp_path: Path) -> dict[str, str]:
    """An environment in which programs find themselves on such a system."""
    (tmp_path / 'sitecustomize.py').write_text(SYSTEMS[selector])
    return isolated_env('rmw_zenoh_cpp') | {'GOALWIRE_ZENOH': 'native', 'PYTHONPATH': str(tmp_path)}


def test_goals_are_reached_cancelled_and_refused(world: dict[str, str], selector: str) -> None:
    with programs_in(world) as start:
        start('fibonacci_server').expect('ready')
        output = start('fibonacci_client').succeed()
    assert 'succeeded [0, 1, 1, 2, 3, 5, 8] after 5 feedback messages' in output
    assert 'canceled with return code 0, 1 goal canceling, [0, 1, 1, 2, 3]' in output
    assert 'refused' in output
    assert f'waited with {selector} True' in output


ECHO = """
import asyncio, sys
import goalwire
from std_msgs.msg import String

async def main(name, said, heard):
    async with goalwire.Node(name) as node:
        messages, publisher = node.subscription(String, heard), node.publisher(String, said)
        await messages.wait_for_publishers(timeout=20)
        await publisher.wait_for_subscribers(timeout=20)
        for size in (0, 70_000, 5_000_000):
            if name == 'here':
                publisher.publish(data='x' * size)
            message = await anext(messages)
            assert len(message.data) == size
            if name == 'there':
                publisher.publish(message)
        print('done', flush=True)
        if name == 'there':
            await asyncio.Event().wait()

asyncio.run(main(*sys.argv[1:]))
"""


def test_messages_in_many_pieces_go_there_and_back(world: dict[str, str], selector: str) -> None:
    with (
        Program(ECHO, 'there', 'to', 'fro', env=world),
        Program(ECHO, 'here', 'fro', 'to', env=world) as here,
    ):
        output = here.succeed()
    assert f'done\nwaited with {selector} True' in output
