"""Keys on a terminal: what is read, what they do, and that the terminal is put back in order."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.bags import write_bag
from helpers.loops import Play
from helpers.patience import PATIENCE

import goalwire
from goalwire.apps.bag.options import PlayOptions
from goalwire.apps.bag.player import Player
from goalwire.apps.cli.commands.bag.keys import keys
from goalwire.apps.cli.commands.bag.play import press
from goalwire.apps.programs.keyboard import DOWN, RIGHT, UP
from goalwire.rosbag2.reader import Reader


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[int, int]]:
    """Both ends of a terminal, one of which is standard input."""
    pty = pytest.importorskip('pty')
    near, far = pty.openpty()
    with os.fdopen(far, 'r', closefd=False) as stream:
        monkeypatch.setattr(sys, 'stdin', stream)
        yield near, far
    os.close(near)
    os.close(far)


def test_keys_are_read_one_by_one(play: Play, terminal: tuple[int, int]) -> None:
    import termios

    near, far = terminal
    before = termios.tcgetattr(far)
    seen: list[str] = []

    async def scenario() -> None:
        with keys(seen.append) as has_keys:
            assert has_keys
            os.write(near, f' {RIGHT}{UP}x'.encode())
            async with asyncio.timeout(PATIENCE):
                while len(seen) < 4:  # noqa: ASYNC110 - nothing tells of it
                    await asyncio.sleep(0.005)

    play(scenario)
    assert seen == [' ', RIGHT, UP, 'x']
    assert termios.tcgetattr(far) == before


def test_without_a_terminal_there_are_no_keys(
    play: Play, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'input').write_text(' ')

    async def scenario() -> None:
        with (tmp_path / 'input').open() as stream:
            monkeypatch.setattr(sys, 'stdin', stream)
            with keys(print) as has_keys:
                assert not has_keys

    play(scenario)


@pytest.mark.parametrize('transport_name', ['goalwire_memory'])
def test_keys_steer_the_player(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('player') as node:
            with Reader(write_bag(tmp_path / 'bag')) as bag:
                player = Player(node, bag, PlayOptions(paused=True))
                for _ in range(3):
                    press(player, RIGHT)
                press(player, UP)
                assert player.rate == pytest.approx(1.1)
                press(player, DOWN)
                assert player.rate == pytest.approx(1.0)
                states = []
                for _ in range(2):
                    press(player, ' ')
                    states.append(player.paused)
                assert states == [False, True]
                playing = asyncio.create_task(player.play())
                async with asyncio.timeout(PATIENCE):
                    while player.published < 3:  # noqa: ASYNC110 - nothing tells of it
                        await asyncio.sleep(0.005)
                player.stop()
                await playing
                assert player.published == 3

    play(scenario)
