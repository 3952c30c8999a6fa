"""The file of an action server's journal: SQLite, written on a thread of its own.

While the server's process lives, no other process can open the file. Its ids are kept for ever (40 bytes
each), so that no id is ever executed twice. Its results are deleted once there are too many of them, or once
they are too old.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from queue import SimpleQueue
from threading import Lock, Thread
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from goalwire.concurrency.threads import begin
from goalwire.durable_files import DurableFile
from goalwire.errors import JournalError
from goalwire.execution.future import Future
from goalwire.records import record
from goalwire.rules.goals.journal import KnownGoal
from goalwire.rules.goals.states import GoalStatus

if TYPE_CHECKING:
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.journal import GoalJournal

T = TypeVar('T')

_FORMAT = 1
_WAIT_S = 5.0
"""How long, in s, to wait for an earlier process that is ending and still holds the file."""
_BEGUN, _DIED = 0, -1
"""Statuses that only the file has: the goal has begun; the goal had begun when its server died.
"""
_TABLES = (
    'CREATE TABLE IF NOT EXISTS file (uuid TEXT NOT NULL)',
    """CREATE TABLE IF NOT EXISTS goal (
        number INTEGER PRIMARY KEY, id BLOB NOT NULL UNIQUE, status INTEGER NOT NULL, ended REAL, result BLOB
    )""",
    'CREATE INDEX IF NOT EXISTS kept ON goal (number) WHERE result IS NOT NULL',
    f'CREATE INDEX IF NOT EXISTS open ON goal (number) WHERE status = {_BEGUN}',
)


@record
class _Job:
    """One read or write, and the future of its outcome."""

    work: Callable[[], Any]
    future: Future[Any]


class JournalFile:
    """The journal of one action server. Its methods return futures, which are done when the data is on the
    disk.
    """

    def __init__(self, settings: GoalJournal) -> None:
        """Open or make the file. Goals that an earlier process did not end count as begun when their server
        died.

        Raises JournalError if the file cannot be opened, or another process has it.
        """
        self.path = Path(settings.path)
        self._settings = settings
        try:
            self._file = DurableFile(self.path, wait_s=_WAIT_S, is_exclusive=True)
            self._db = self._file.db
            try:
                with self._file.explaining('opened'):
                    self._prepare()
            except BaseException:
                self._file.close()
                raise
        except JournalError as error:
            if 'locked' in str(error):
                error.add_note('a journal belongs to one action server: another process may have it')
            raise
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._closing = Lock()
        self._closed = False
        self._thread = Thread(target=self._work, name='goalwire-goals', daemon=True)
        begin(self._thread)

    def _prepare(self) -> None:
        (found,) = self._db.execute('PRAGMA user_version').fetchone()
        if found not in {0, _FORMAT}:
            raise JournalError(f"'{self.path}' has the format {found}, and this goalwire reads {_FORMAT}")
        with self._file.transaction():
            for statement in _TABLES:
                self._db.execute(statement)
            self._db.execute(f'PRAGMA user_version = {_FORMAT}')
            if self._db.execute('SELECT count(*) FROM file').fetchone() == (0,):
                self._db.execute('INSERT INTO file VALUES (?)', (str(uuid4()),))
            self._db.execute('UPDATE goal SET status = ? WHERE status = ?', (_DIED, _BEGUN))
        self.uuid = str(self._db.execute('SELECT uuid FROM file').fetchone()[0])

    # -- goals ---------------------------------------------------------------------------------------------

    def find(self, goal_id: GoalId) -> Future[KnownGoal | None]:
        """Return what is known of a goal; None if this journal never had the goal."""
        return self._post(lambda: self._find(goal_id))

    def begin(self, goal_id: GoalId) -> Future[bool]:
        """Write that a goal is accepted, before it is executed. Return False, and write nothing, if the
        journal has its id.
        """
        return self._post(lambda: self._begin(goal_id))

    def forget(self, goal_id: GoalId) -> Future[None]:
        """Take back `begin`: the goal was refused after all."""
        return self._post(lambda: self._write('DELETE FROM goal WHERE id = ?', goal_id))

    def end(self, goal_id: GoalId, status: GoalStatus, result: bytes | None) -> Future[None]:
        """Write how a goal has ended. A `result` of None stands for the type's default result."""
        return self._post(lambda: self._end(goal_id, status, result or b''))

    def _find(self, goal_id: GoalId) -> KnownGoal | None:
        found = self._db.execute('SELECT status, result FROM goal WHERE id = ?', (goal_id,)).fetchone()
        if found is None:
            return None
        status, result = found
        if status == _DIED:
            return KnownGoal(GoalStatus.ABORTED, b'', server_died=True)
        return KnownGoal(GoalStatus(status), result)

    def _begin(self, goal_id: GoalId) -> bool:
        sql = 'INSERT OR IGNORE INTO goal (id, status) VALUES (?, ?)'
        return self._db.execute(sql, (goal_id, _BEGUN)).rowcount == 1

    def _end(self, goal_id: GoalId, status: GoalStatus, result: bytes) -> None:
        now = time.time()
        self._write(
            'UPDATE goal SET status = ?, ended = ?, result = ? WHERE id = ?',
            int(status),
            now,
            result,
            goal_id,
        )
        (newest,) = self._db.execute('SELECT max(number) FROM goal').fetchone()
        self._write(
            'UPDATE goal SET result = NULL WHERE result IS NOT NULL AND (number <= ? OR ended <= ?)',
            (newest or 0) - self._settings.results,
            now - self._settings.age,
        )

    def _write(self, sql: str, *values: object) -> None:
        self._db.execute(sql, values)

    # -- its thread ----------------------------------------------------------------------------------------

    def _post(self, work: Callable[[], T]) -> Future[T]:
        future: Future[T] = Future()
        with self._closing:
            if not self._closed:
                self._jobs.put(_Job(work, future))
                return future
        future.set_exception(JournalError(f"the journal '{self.path}' is closed"))
        return future

    def _work(self) -> None:
        is_open = True
        while is_open:
            jobs = [self._jobs.get()]
            while not self._jobs.empty():  # all share one commit: a disk takes as long for many as for one
                jobs.append(self._jobs.get())
            is_open = None not in jobs
            self._commit([job for job in jobs if job is not None])
        self._file.close()

    def _commit(self, jobs: list[_Job]) -> None:
        try:
            with self._file.transaction():
                outcomes = [job.work() for job in jobs]
        except JournalError as error:
            for job in jobs:
                job.future.set_exception(error)
        else:
            for job, outcome in zip(jobs, outcomes, strict=True):
                job.future.set_result(outcome)

    def close(self) -> None:
        """Finish the queued jobs, and release the file. Idempotent."""
        with self._closing:
            if not self._closed:
                self._closed = True
                self._jobs.put(None)
        self._thread.join()
