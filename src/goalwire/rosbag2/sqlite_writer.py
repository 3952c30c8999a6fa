"""Writes one sqlite3 file of a bag, in the layout of rosbag2 since Iron (version 4)."""

from __future__ import annotations

import os
import sqlite3
from collections import Counter

from goalwire.rosbag2.metadata import NEWEST, qos_text
from goalwire.rosbag2.model import Message, Topic

_TABLES = """
CREATE TABLE schema (schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata (id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics (
  id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
  offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions (
  id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages (
  id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


class SqliteWriter:
    """Writes a new file. Any thread may use it, but only one at a time."""

    def __init__(self, path: str, ros_distro: str) -> None:
        """Make the file; raises OSError, FileExistsError."""
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o644))
        self.path = path
        self.start = self.end = self.count = self.size = 0
        self._numbers: dict[str, int] = {}
        self._types: set[str] = set()
        self._counts: Counter[str] = Counter()
        self._closed = False
        self._database = sqlite3.connect(path, check_same_thread=False)
        self._run(self._make_tables, ros_distro)

    def _make_tables(self, ros_distro: str) -> None:
        self._database.executescript(_TABLES)
        self._database.execute('INSERT INTO schema VALUES (4, ?)', (ros_distro,))
        self._database.commit()

    def add_topic(self, topic: Topic) -> None:
        """Register a topic; to be called once, before the topic's first message."""
        self._numbers[topic.name] = len(self._numbers) + 1
        self._run(self._insert_topic, topic)

    def _insert_topic(self, topic: Topic) -> None:
        if topic.type_name not in self._types:
            self._types.add(topic.type_name)
            self._database.execute(
                'INSERT INTO message_definitions (topic_type, encoding, encoded_message_definition, '
                'type_description_hash) VALUES (?, ?, ?, ?)',
                (topic.type_name, topic.schema.encoding or 'unknown', topic.schema.text, topic.type_hash),
            )
        self._database.execute(
            'INSERT INTO topics VALUES (?, ?, ?, ?, ?, ?)',
            (
                self._numbers[topic.name],
                topic.name,
                topic.type_name,
                topic.serialization,
                qos_text(topic.qos),
                topic.type_hash,
            ),
        )

    def write(self, message: Message) -> None:
        """Add a message; raises OSError."""
        self._run(self._insert, message)
        if not self.count:
            self.start = self.end = message.time
        self.start, self.end = min(self.start, message.time), max(self.end, message.time)
        self.count += 1
        self.size += len(message.data) + 32

    def _insert(self, message: Message) -> None:
        row = (self._numbers[message.topic], message.time, message.data)
        self._database.execute('INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)', row)

    def wants_end(self) -> bool:
        """Return False: in this format no flush is due early."""
        return False

    def flush(self, metadata: str) -> None:
        """Commit the messages and the metadata; raises OSError."""
        self._run(self._commit, metadata)

    def _commit(self, metadata: str) -> None:
        self._database.execute('DELETE FROM metadata')
        self._database.execute(
            'INSERT INTO metadata (metadata_version, metadata) VALUES (?, ?)', (NEWEST, metadata)
        )
        self._database.commit()

    def sync(self) -> None:
        """Do nothing: sqlite writes every commit to the disk."""

    def close(self, metadata: str) -> None:
        """Commit, and close the file. Idempotent. Raises OSError."""
        if self._closed:
            return
        self._closed = True
        try:
            self.flush(metadata)
        finally:
            self._database.close()

    def _run(self, work: object, *arguments: object) -> None:
        try:
            work(*arguments)  # type: ignore[operator]
        except sqlite3.Error as error:
            raise OSError(0, str(error), self.path) from error
