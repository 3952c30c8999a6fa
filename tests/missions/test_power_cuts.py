"""The power is cut while journals are written: what was not synced is lost, wholly or in parts.

SQLite syncs the WAL at the end of each commit, and the database file before it begins the WAL anew (PRAGMA
synchronous=FULL, https://sqlite.org/pragma.html). A cut is played on copies: everything up to the last commit
that has returned is there, and of the writes after it any sectors, in any order, and torn ones.
"""

from __future__ import annotations

import os
import random
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, TypeVar

from goalwire.entities.actions.journal_file import JournalFile
from goalwire.execution.future import Future
from goalwire.missions.journal_store import Change, MissionRow, Store
from goalwire.rules.goals.journal import GoalJournal
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.missions.entries import Entry, EntryKind, MissionState

T = TypeVar('T')

CUTS = int(os.environ.get('GOALWIRE_TEST_POWER_CUTS', '60'))
COMMITS = 60
SECTOR = 512
HEADER = 32
"""Bytes of a WAL before its frames."""
PAGES_BEFORE_CHECKPOINT = 12


class Disk(NamedTuple):
    """The two files of a journal at one moment."""

    database: bytes
    wal: bytes

    @classmethod
    def of(cls, path: Path) -> Disk:
        """Return what the files have now."""
        wal = path.with_name(f'{path.name}-wal')
        return cls(path.read_bytes(), wal.read_bytes() if wal.exists() else b'')

    def put(self, path: Path) -> None:
        """Write the files, as a machine finds them when it starts again."""
        path.write_bytes(self.database)
        path.with_name(f'{path.name}-wal').write_bytes(self.wal)
        path.with_name(f'{path.name}-shm').unlink(missing_ok=True)


def cut(before: Disk, after: Disk, chance: random.Random) -> Disk:
    """Return what a cut between two commits leaves: `before` was synced, `after` was being written."""
    if before.database != after.database:  # a checkpoint, whose WAL was synced before it began
        return Disk(torn(before.database, after.database, chance), after.wal)
    head = after.wal[:HEADER]
    if before.wal[:HEADER] == head:
        return Disk(before.database, torn(before.wal, after.wal, chance))
    if chance.random() < 0.3:  # the WAL begins anew: its head is synced before anything else of it
        length = chance.randrange(HEADER)
        return Disk(before.database, head[:length] + before.wal[length:])
    return Disk(before.database, torn(head + before.wal[HEADER:], after.wal, chance))


def torn(synced: bytes, written: bytes, chance: random.Random) -> bytes:
    """Return synced bytes over which some of the later sectors were written, and one of them in part."""
    length = chance.choice([len(synced), len(written), chance.randint(*sorted((len(synced), len(written))))])
    disk = bytearray(synced[:length].ljust(length, b'\0'))
    share = chance.random()
    for start in range(0, min(length, len(written)), SECTOR):
        if chance.random() < share:
            end = min(start + (SECTOR if chance.random() < 0.95 else chance.randrange(SECTOR)), length)
            disk[start:end] = written[start:end]
    return bytes(disk)


def test_a_cut_takes_only_what_was_not_synced() -> None:
    chance = random.Random(1)
    for _ in range(100):
        found = cut(Disk(b'a' * 4096, b'w' * 1000), Disk(b'a' * 4096, b'w' * 1000 + b'x' * 3000), chance)
        assert found.database == b'a' * 4096
        assert found.wal[:1000] == b'w' * 1000
        assert set(found.wal[1000:]) <= {0, ord('x')}


def test_no_entry_of_a_mission_is_lost_that_was_committed(tmp_path: Path) -> None:
    path = tmp_path / 'missions.db'
    disks = []
    with Store(path) as store:
        store._db.execute(f'PRAGMA wal_autocheckpoint={PAGES_BEFORE_CHECKPOINT}')
        now = 0.0
        store.add(MissionRow('m', 'carry', 1, '', (), MissionState.RUNNING, '', now, now))
        for number in range(COMMITS):
            entry = Entry(EntryKind.INTENT, number, {'kind': 'goal', 'goal_id': f'{number:032x}'}, bytes(700))
            store.commit([Change('m', (entry,))], now)
            disks.append(Disk.of(path))

    def check(committed: int) -> None:
        with Store(path) as found:
            assert found._db.execute('PRAGMA integrity_check').fetchall() == [('ok',)]
            steps = [entry.step for entry in found.entries('m')]
            assert steps in (list(range(committed)), list(range(committed + 1)))
            more = Entry(EntryKind.INTENT, len(steps), {'kind': 'goal'})
            found.commit([Change('m', (more,))], 0.0)  # it can be written, too

    cut_often(path, disks, check)


def test_no_goal_of_a_server_is_lost_that_was_committed(tmp_path: Path) -> None:
    path = tmp_path / 'job.goals'
    settings = GoalJournal(path)
    disks = []
    file = JournalFile(settings)
    done(file._post(lambda: file._db.execute(f'PRAGMA wal_autocheckpoint={PAGES_BEFORE_CHECKPOINT}')))
    for number in range(COMMITS // 2):
        assert done(file.begin(number.to_bytes(16, 'big'))) is True
        disks.append(Disk.of(path))
        done(file.end(number.to_bytes(16, 'big'), GoalStatus.SUCCEEDED, bytes(700)))
        disks.append(Disk.of(path))
    file.close()

    def check(committed: int) -> None:
        found = JournalFile(settings)
        for number in range((committed + 1) // 2):
            goal = done(found.find(number.to_bytes(16, 'big')))
            assert goal is not None
            assert goal.server_died or goal.status is GoalStatus.SUCCEEDED
            assert not (goal.server_died and 2 * number + 1 < committed)
        assert done(found.begin(b'another goal 16b')) is True
        found.close()

    cut_often(path, disks, check)


def cut_often(path: Path, disks: list[Disk], check: Callable[[int], None]) -> None:
    """Cut the power between two commits, again and again. `check` gets the number of those before the cut."""
    chance = random.Random(7)
    checkpoints = sum(before.database != after.database for before, after in pairwise(disks))
    assert checkpoints > 3
    for _ in range(CUTS):
        number = chance.randrange(len(disks) - 1)
        cut(disks[number], disks[number + 1], chance).put(path)
        check(number + 1)


def done(future: Future[T]) -> T:
    """Wait for the disk."""
    assert future.wait()
    return future.result()
