"""The journal's file: what happens if the disk is full, the folder read-only, or the file another one."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from example_interfaces.action import Fibonacci
from helpers.missions import Base, Robot, play

from goalwire.errors import JournalError
from goalwire.missions import Runner, Steps, mission
from goalwire.missions.journal_store import Change, MissionRow, Store
from goalwire.rules.missions.entries import Entry, EntryKind, MissionState

PLACES = 20


@mission()
async def trip(m: Steps) -> None:
    drive = m.action(Fibonacci, 'drive')
    for place in range(20, 20 + PLACES):
        await drive.call(order=place)


def test_no_step_begins_on_a_full_disk_and_the_mission_goes_on_when_there_is_room(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            async with base.runner(trip) as runner:
                run = await runner.start(trip, id='m')
                await robot.until(1)
                database = runner._open_writer().store._db
                (pages,) = database.execute('PRAGMA page_count').fetchone()
                database.execute(f'PRAGMA max_page_count = {pages}')  # what is left of them is soon used up
                with pytest.raises(JournalError, match='full'):
                    await run.wait()
                assert run.state is MissionState.RUNNING
                assert 1 <= len(robot.places) < PLACES
            async with base.runner(trip) as runner:
                (run,) = runner.missions()
                await run.wait()
            assert robot.places == list(range(20, 20 + PLACES))
            assert set(robot.executed.values()) == {1}

    play(scenario)


def test_all_who_wait_for_a_mission_hear_that_its_journal_is_broken(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            async with base.runner(trip) as runner:
                run = await runner.start(trip, id='m')
                await robot.until(1)
                waiting = [
                    asyncio.ensure_future(each)
                    for each in (run.wait(), run.until(MissionState.LOST), runner.serve())
                ]
                with base.broken():
                    heard = await asyncio.gather(*waiting, return_exceptions=True)
                assert [type(each) for each in heard] == [JournalError] * 3
                assert 'was deleted or replaced' in str(heard[2])
                assert await run.until(MissionState.RUNNING) is MissionState.RUNNING
            async with base.runner(trip) as runner:
                (run,) = runner.missions()
                assert await run.until(MissionState.LOST) is MissionState.SUCCEEDED
            assert robot.places == list(range(20, 20 + PLACES))

    play(scenario)


def test_what_is_no_journal_is_left_as_it_is(base: Base, tmp_path: Path) -> None:
    async def scenario() -> None:
        base.path.write_bytes(b'a letter, and no database\n' * 100)
        before = base.path.read_bytes()
        with pytest.raises(JournalError, match='not a database'):
            async with base.runner(trip):
                pass
        assert base.path.read_bytes() == before
        base.path = tmp_path / 'nowhere' / 'missions.db'
        with pytest.raises(JournalError, match='cannot be opened: No such file'):
            async with base.runner(trip):
                pass

    play(scenario)


def test_a_reader_needs_a_journal_that_is_there(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match='there is no journal'):
        Store(tmp_path / 'missions.db', must_exist=True)
    assert list(tmp_path.iterdir()) == []


def test_a_newer_format_is_refused(tmp_path: Path) -> None:
    with Store(tmp_path / 'missions.db') as store:
        store.set_fact('format', '2')
    with pytest.raises(JournalError, match='has the format 2, and this goalwire reads 1'):
        Store(tmp_path / 'missions.db')


def test_entries_come_back_as_they_were_written(tmp_path: Path) -> None:
    entries = tuple(
        Entry(kind, step, {'text': 'ü', 'values': [1, 2.5, None, True]}, bytes(range(5)), 12.5)
        for step, kind in enumerate(EntryKind)
    )
    row = MissionRow('m', 'trip', 3, 'f', (4, 'a'), MissionState.RUNNING, '', 1.0, 1.0)
    with Store(tmp_path / 'missions.db') as store:
        uuid = store.uuid
        store.add(row)
        store.commit([Change('m', entries[:3])], 2.0)
        store.commit([Change('m', entries[3:], MissionState.FAILED, 'why')], 3.0)
    with Store(tmp_path / 'missions.db', must_exist=True) as store:
        assert store.uuid == uuid
        assert store.entries('m') == list(entries)
        (found,) = store.missions()
        assert (found.state, found.why, found.changed, found.arguments) == (
            MissionState.FAILED,
            'why',
            3.0,
            (4, 'a'),
        )


def test_a_commit_that_fails_changes_nothing(tmp_path: Path) -> None:
    entry = Entry(EntryKind.NOTE, -1, {})
    row = MissionRow('m', 'trip', 1, '', (), MissionState.RUNNING, '', 1.0, 1.0)
    with Store(tmp_path / 'missions.db') as store:
        store.add(row)
        store.commit([Change('m', (entry,))], 2.0)
        with pytest.raises(TypeError):
            store.commit([Change('m', (entry, Entry(EntryKind.NOTE, -1, {'x': object()})))], 3.0)  # type: ignore[dict-item]
        store.commit([Change('m', (entry,))], 4.0)
        assert len(store.entries('m')) == 2
        with pytest.raises(JournalError):
            store.add(row)


def test_a_runner_is_used_in_its_block(base: Base) -> None:
    async def scenario() -> None:
        async with base.graph.node('runner') as node:
            runner = Runner(node, base.path)
            with pytest.raises(Exception, match='works in its block'):
                await runner.start(trip)

    play(scenario)
