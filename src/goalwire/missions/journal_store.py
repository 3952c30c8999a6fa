"""The file of a journal: SQLite, durable at each commit, with one runner at a time.

Every commit reaches the disk before it returns (WAL and `synchronous=FULL`: with NORMAL a power cut may undo
a commit, and a goal might be sent whose intent is lost). Only the runner writes the journal. Other processes
read it, and write commands into a table of their own, which the runner reads. So a command that is given
while no runner is there is not lost.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Self
from uuid import uuid4

from goalwire.durable_files import DurableFile
from goalwire.errors import JournalError
from goalwire.records import record
from goalwire.rules.missions.entries import Entry, EntryKind, MissionState

if TYPE_CHECKING:
    from types import TracebackType

    from goalwire.rules.missions.entries import Json

FORMAT = '1'
LARGEST_VALUE = 2**16
"""The largest value or message in the journal, in bytes. Larger values belong into files."""
_BUSY_S = 10.0
_TABLES = """
CREATE TABLE IF NOT EXISTS file (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS mission (
    id TEXT PRIMARY KEY, name TEXT NOT NULL, version INTEGER NOT NULL, fingerprint TEXT NOT NULL,
    arguments TEXT NOT NULL, state TEXT NOT NULL, why TEXT NOT NULL, begun REAL NOT NULL,
    changed REAL NOT NULL, result TEXT
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS entry (
    mission TEXT NOT NULL, number INTEGER NOT NULL, kind TEXT NOT NULL, step INTEGER NOT NULL,
    body TEXT NOT NULL, data BLOB NOT NULL, at REAL NOT NULL, PRIMARY KEY (mission, number)
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS command (
    number INTEGER PRIMARY KEY AUTOINCREMENT, mission TEXT NOT NULL, verb TEXT NOT NULL, body TEXT NOT NULL
);
"""


@record
class MissionRow:
    """One mission of the journal, as lists show it."""

    id: str
    name: str
    version: int
    fingerprint: str
    arguments: tuple[Json, ...]
    state: MissionState
    why: str
    """The reason why the mission waits, or why it ended as it did."""
    begun: float
    """The time at which the mission began, in s since 1970; `changed` is the time of its latest change."""
    changed: float
    result: Json = None


@record
class Change:
    """The changes of one commit to one mission."""

    mission: str
    entries: tuple[Entry, ...] = ()
    state: MissionState | None = None
    why: str = ''
    result: Json = None


@record
class Command:
    """A person's command to a mission."""

    number: int
    mission: str
    verb: str
    body: Mapping[str, Json]


class Store:
    """One journal file. Its methods block until the disk has answered; one thread at a time may use it."""

    def __init__(self, path: str | Path, *, must_exist: bool = False) -> None:
        """Open or make the file. Raises JournalError."""
        self.path = Path(path)
        self._last: dict[str, int] = {}
        if must_exist and not self.path.is_file():
            raise JournalError(f"there is no journal '{self.path}': name the file that a Runner was given")
        self._file = DurableFile(self.path, wait_s=_BUSY_S)
        self._db = self._file.db
        try:
            with self._file.explaining('opened'):
                self._prepare(must_exist=must_exist)
        except BaseException:
            self._file.close()
            raise

    def _prepare(self, *, must_exist: bool) -> None:
        if not must_exist:
            self._make_tables()
        found = self.fact('format')
        if found != FORMAT:
            raise JournalError(f"'{self.path}' has the format {found}, and this goalwire reads {FORMAT}")
        self.uuid = self.fact('uuid')

    def _make_tables(self) -> None:
        with self._transaction():
            for statement in _TABLES.split(';\n'):
                self._db.execute(statement)
            for key, value in (('format', FORMAT), ('uuid', str(uuid4()))):
                self._db.execute('INSERT OR IGNORE INTO file VALUES (?, ?)', (key, value))

    def fact(self, key: str) -> str:
        """Return a stored fact about the file; '' if it does not exist."""
        with self._file.explaining('read'):
            found = self._db.execute('SELECT value FROM file WHERE key = ?', (key,)).fetchone()
        return '' if found is None else str(found[0])

    def set_fact(self, key: str, value: str) -> None:
        """Keep a fact about the file."""
        with self._transaction():
            self._db.execute('INSERT OR REPLACE INTO file VALUES (?, ?)', (key, value))

    def first_time(self, key: str, now: float) -> float:
        """Return when this method was first called with `key`; if that is now, keep the time."""
        known = self.fact(key)
        if not known:
            self.set_fact(key, repr(now))
        return float(known or now)

    # -- the journal ---------------------------------------------------------------------------------------

    def add(self, row: MissionRow, *entries: Entry) -> None:
        """Begin the journal of a mission, whose id must be new, with its first entries."""
        values = (
            row.id, row.name, row.version, row.fingerprint, as_json(row.arguments), row.state, row.why,
            row.begun, row.changed, None,
        )  # fmt: skip
        with self._transaction():
            self._db.execute('INSERT INTO mission VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)', values)
            self._write(Change(row.id, entries), row.begun)

    def commit(self, changes: Iterable[Change], at: float) -> None:
        """Write changes to the disk, all or none of them. Raises JournalError."""
        with self._transaction():
            for change in changes:
                self._write(change, at)

    def _write(self, change: Change, at: float) -> None:
        number = self._last.get(change.mission, -1)
        if number < 0:
            found = self._db.execute('SELECT max(number) FROM entry WHERE mission = ?', (change.mission,))
            (last,) = found.fetchone()
            number = -1 if last is None else last
        for entry in change.entries:
            number += 1
            values = (
                change.mission, number, entry.kind, entry.step, as_json(entry.body), entry.data, entry.at,
            )  # fmt: skip
            self._db.execute('INSERT INTO entry VALUES (?, ?, ?, ?, ?, ?, ?)', values)
        self._last[change.mission] = number
        if change.state is not None:
            self._db.execute(
                'UPDATE mission SET state = ?, why = ?, changed = ?, result = ? WHERE id = ?',
                (change.state, change.why, at, as_json(change.result), change.mission),
            )

    def missions(self) -> list[MissionRow]:
        """Return all missions, in the order of their beginning."""
        with self._file.explaining('read'):
            return [_row(found) for found in self._db.execute('SELECT * FROM mission ORDER BY begun, id')]

    def mission(self, id_: str) -> MissionRow | None:
        """Return one mission."""
        with self._file.explaining('read'):
            found = self._db.execute('SELECT * FROM mission WHERE id = ?', (id_,)).fetchone()
        return None if found is None else _row(found)

    def entries(self, id_: str) -> list[Entry]:
        """Return the journal of a mission, in the order of its writing."""
        with self._file.explaining('read'):
            found = self._db.execute(
                'SELECT kind, step, body, data, at FROM entry WHERE mission = ? ORDER BY number', (id_,)
            ).fetchall()
        return [
            Entry(EntryKind(kind), step, json.loads(body), data, at) for kind, step, body, data, at in found
        ]

    # -- commands ------------------------------------------------------------------------------------------

    def command(self, mission: str, verb: str, body: Mapping[str, Json]) -> None:
        """Leave a command for the runner."""
        with self._transaction():
            self._db.execute(
                'INSERT INTO command (mission, verb, body) VALUES (?, ?, ?)', (mission, verb, as_json(body))
            )

    def commands(self) -> list[Command]:
        """Return the commands that were not removed yet, in their order."""
        with self._file.explaining('read'):
            found = self._db.execute(
                'SELECT number, mission, verb, body FROM command ORDER BY number'
            ).fetchall()
        return [Command(number, mission, verb, json.loads(body)) for number, mission, verb, body in found]

    def take_command(self, number: int) -> None:
        """Remove a command that was carried out or came too late."""
        with self._transaction():
            self._db.execute('DELETE FROM command WHERE number = ?', (number,))

    # -- its life ------------------------------------------------------------------------------------------

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        try:
            with self._file.transaction():
                yield
        except BaseException:
            self._last.clear()
            raise

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def as_json(value: Json) -> str:
    """Return a value as the journal keeps it. Raises TypeError for what JSON cannot hold, ValueError if it is
    too large.
    """
    text = json.dumps(value, ensure_ascii=False)
    if len(text) > LARGEST_VALUE:
        raise ValueError(f'a value in a journal has {LARGEST_VALUE:,} characters at most, not {len(text):,}')
    return text


def _row(found: tuple[object, ...]) -> MissionRow:
    id_, name, version, fingerprint, arguments, state, why, begun, changed, result = found
    return MissionRow(
        str(id_), str(name), int(str(version)), str(fingerprint), tuple(json.loads(str(arguments))),
        MissionState(str(state)), str(why), float(str(begun)), float(str(changed)),
        None if result is None else json.loads(str(result)),
    )  # fmt: skip
