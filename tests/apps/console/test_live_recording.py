"""The console's recording, without a page: one bag at a time, of the names that are wanted."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from helpers.loops import Play

import goalwire
from goalwire.apps.console.settings import Settings
from goalwire.apps.console.state.live_recording import LiveRecording, Wanted
from goalwire.errors import BagError, NotAllowedError
from goalwire.rosbag2.reader import Reader


def _recording(node: goalwire.Node, folder: Path, *, read_only: bool = False) -> LiveRecording:
    return LiveRecording(node, Settings(record_to=str(folder), read_only=read_only))


def test_a_bag_that_cannot_be_made_is_told(play: Play, tmp_path: Path) -> None:
    (tmp_path / 'file').touch()

    async def scenario() -> None:
        async with goalwire.Node('console') as node:
            recording = _recording(node, tmp_path / 'file')
            with pytest.raises(BagError, match='Not a directory'):
                await recording.start(Wanted())
            assert not recording.is_running
            with pytest.raises(NotAllowedError, match='--read-only'):
                await _recording(node, tmp_path, read_only=True).start(Wanted())

    play(scenario)
    assert list(tmp_path.iterdir()) == [tmp_path / 'file']


def test_the_second_of_two_who_press_at_once_is_refused(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('console') as node:
            recording = _recording(node, tmp_path)
            both = [recording.start(Wanted()), recording.start(Wanted())]
            answers = await asyncio.gather(*both, return_exceptions=True)
            assert [type(each) for each in answers] == [type(None), BagError]
            await asyncio.gather(recording.stop(), recording.stop())
            assert not recording.is_running
            with Reader(recording.path) as bag:
                assert bag.problems == []

    play(scenario)


@pytest.mark.parametrize(
    ('names', 'out', 'expected'),
    [
        ((), (), {'/arm/a', '/arm', '/tf', '/legs/arm'}),
        (('/arm/*',), (), {'/arm/a'}),
        (('/arm*', '/tf'), ('*/a',), {'/arm', '/tf'}),
        ((), ('/arm*',), {'/tf', '/legs/arm'}),
    ],
)
def test_globs_are_of_whole_names(names: tuple[str, ...], out: tuple[str, ...], expected: set[str]) -> None:
    selection = Wanted(names, out).selection
    there = ('/arm/a', '/arm', '/tf', '/legs/arm')
    assert {name for name in there if selection.wants(name, 'std_msgs/msg/String')} == expected
    assert {name for name in there if selection.wants(f'{name}/_service_event', '')} == expected
