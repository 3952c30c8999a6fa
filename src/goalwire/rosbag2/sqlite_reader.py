"""Reads one sqlite3 file of a bag, in any of the four layouts that rosbag2 has written."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.errors import BagError
from goalwire.files import show
from goalwire.rosbag2.metadata import qos_of_text
from goalwire.rosbag2.model import Message, Schema, Topic

if TYPE_CHECKING:
    from typing import Self

_BROKEN = (sqlite3.Error, UnicodeDecodeError)
"""The errors that sqlite3 raises for a broken file; the second if the name of a column is not UTF-8."""


class SqliteReader:
    """Reads a file; a context manager. Only the thread that made it may use it."""

    storage = 'sqlite3'
    problem = ''

    def __init__(self, path: str) -> None:
        """Open the file; raises BagError."""
        self.path = path
        self.metadata = ''
        self.topics: list[Topic] = []
        self.counts: Counter[str] = Counter()
        self.start = self.end = 0
        self._numbers: dict[int, str] = {}
        place = Path(path).absolute().as_uri()
        try:
            # A killed writer leaves a journal, which sqlite plays back into the file: so the file is opened
            # for writing.
            self._database = sqlite3.connect(f'{place}?mode=rw', uri=True)
        except sqlite3.Error:
            self._database = self._open(f'{place}?immutable=1')
        try:
            self._read()
        except sqlite3.OperationalError as error:  # the folder may be read-only
            self._database.close()
            self._database = self._open(f'{place}?immutable=1')
            try:
                self._read()
            except _BROKEN:
                self._database.close()
                raise self._make_error(error) from error
        except _BROKEN as error:
            self._database.close()
            raise self._make_error(error) from error

    def _open(self, place: str) -> sqlite3.Connection:
        try:
            return sqlite3.connect(place, uri=True)
        except sqlite3.Error as error:
            raise self._make_error(error) from error

    def _make_error(self, error: Exception) -> BagError:
        return BagError(f'{show(self.path)}: it cannot be read as a sqlite3 bag ({error})')

    @property
    def count(self) -> int:
        """The number of messages in the file."""
        return self.counts.total()

    def _read(self) -> None:
        columns = self._columns('topics')
        if not columns or not self._columns('messages'):
            raise sqlite3.DatabaseError('it has no tables of messages and topics')
        schemas = self._schemas()
        # Older layouts lack these two columns: their values are read as ''.
        qos_column = 'offered_qos_profiles' if 'offered_qos_profiles' in columns else "''"
        hash_column = 'type_description_hash' if 'type_description_hash' in columns else "''"
        for number, name, type_name, serialization, qos, type_hash in self._database.execute(
            f'SELECT id, name, type, serialization_format, {qos_column}, {hash_column} '  # noqa: S608 - ours
            'FROM topics ORDER BY id'
        ):
            self._numbers[number] = name
            schema = schemas.get(type_name, Schema())
            self.topics.append(
                Topic(name, type_name, type_hash or '', qos_of_text(qos or ''), schema, serialization)
            )
        for number, count in self._database.execute(
            'SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id'
        ):
            if number in self._numbers:
                self.counts[self._numbers[number]] += count
        start, end = self._database.execute('SELECT MIN(timestamp), MAX(timestamp) FROM messages').fetchone()
        self.start, self.end = start or 0, end or 0
        if self._columns('metadata'):
            found = self._database.execute(
                'SELECT metadata FROM metadata ORDER BY id DESC LIMIT 1'
            ).fetchone()
            self.metadata = found[0] if found else ''

    def _columns(self, table: str) -> set[str]:
        return {row[1] for row in self._database.execute(f'PRAGMA table_info({table})')}

    def _schemas(self) -> dict[str, Schema]:
        if not self._columns('message_definitions'):
            return {}
        rows = self._database.execute(
            'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions'
        )
        return {
            name: Schema('' if encoding == 'unknown' else encoding, text) for name, encoding, text in rows
        }

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Message]:
        """Yield messages in the order of their times; see McapReader.messages."""
        wanted = [number for number, name in self._numbers.items() if topics is None or name in topics]
        conditions = [f'topic_id IN ({",".join("?" * len(wanted))})']
        values = list(wanted)
        for condition, value in (('timestamp >= ?', start), ('timestamp < ?', stop)):
            if value is not None:
                conditions.append(condition)
                values.append(value)
        query = f'SELECT topic_id, timestamp, data FROM messages WHERE {" AND ".join(conditions)} '  # noqa: S608
        try:
            for number, time, data in self._database.execute(query + 'ORDER BY timestamp, id', values):
                yield Message(self._numbers[number], time, data, time)
        except sqlite3.Error as error:
            raise self._make_error(error) from error

    def check(self) -> Iterator[str]:
        """Read every byte of the file, and yield a text for each fault."""
        try:
            for (line,) in self._database.execute('PRAGMA integrity_check'):
                if line != 'ok':
                    yield line
        except sqlite3.Error as error:
            yield str(error)

    def rescued(self) -> Iterator[Message]:
        """Yield the messages before the first one that cannot be read."""
        try:
            yield from self.messages()
        except BagError:
            return

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._database.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
