"""The error that is raised if nothing can ever happen again."""

from __future__ import annotations

import asyncio
import runpy
import threading
from pathlib import Path

import pytest

import goalwire
from goalwire.testing import DeadlockError, Graph, VirtualClock


def test_where_everything_waits_for_ever_it_is_said_who_waits_where(clock: VirtualClock) -> None:
    async def mission() -> None:
        await asyncio.Event().wait()

    def serve() -> None:
        gate.wait()

    gate = threading.Event()
    server = threading.Thread(target=serve, name='server', daemon=True)  # a failure leaves it waiting
    server.start()
    with pytest.raises(DeadlockError) as caught:
        asyncio.run(mission())
    text = str(caught.value)
    assert "thread 'MainThread' waits" in text
    assert "thread 'server' waits" in text
    assert f'{__file__}' in text
    assert 'in serve' in text
    assert 'in mission' in text
    gate.set()
    server.join()


def test_a_deadlock_is_told_to_the_thread_of_the_block(clock: VirtualClock) -> None:
    gate = threading.Event()
    thread = threading.Thread(target=gate.wait, daemon=True)
    thread.start()
    with pytest.raises(DeadlockError):
        thread.join()
    gate.set()
    thread.join()


def test_a_node_in_a_loop_brings_no_outside_world_in(clock: VirtualClock, gw_graph: Graph) -> None:
    async def mission() -> None:
        async with goalwire.Node('worker') as node, asyncio.timeout(10):
            await node.clock.sleep(5)
        async with goalwire.Node('worker'):
            await asyncio.Event().wait()

    with pytest.raises(DeadlockError):
        asyncio.run(mission())


def test_the_innermost_places_of_the_program_come_first(clock: VirtualClock) -> None:
    def outer() -> None:
        inner()

    def inner() -> None:
        threading.Event().wait()

    with pytest.raises(DeadlockError) as caught:
        outer()
    text = str(caught.value)
    assert text.index('in inner') < text.index('in outer')
    assert 'threading.py' not in text


@pytest.mark.parametrize('folder', ['goalwire', 'src/goalwire/tests', 'pytest-tests', 'lib/python'])
def test_a_folder_may_have_any_name(clock: VirtualClock, tmp_path: Path, folder: str) -> None:
    """Only the folders where the library, Python and what is installed lie are passed over."""
    below = tmp_path / folder
    below.mkdir(parents=True)
    lines = 'import threading', 'def wait_for_ever():', '    threading.Event().wait()'
    (below / 'mission_of_a_user.py').write_text('\n'.join(lines))
    wait_for_ever = runpy.run_path(str(below / 'mission_of_a_user.py'))['wait_for_ever']
    with pytest.raises(DeadlockError) as caught:
        wait_for_ever()
    first = str(caught.value).splitlines()[2]
    assert first == f'    {below / "mission_of_a_user.py"}:3 in wait_for_ever'
