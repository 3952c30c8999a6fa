"""The lock of a journal: whoever asks whether a runner has it never keeps a runner from starting."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from goalwire.errors import JournalError
from goalwire.missions.file_lock import FileLock, has_runner, lock_path


def test_the_lock_tells_whether_a_runner_has_the_journal(tmp_path: Path) -> None:
    journal = tmp_path / 'missions.db'
    assert not has_runner(journal)
    lock = FileLock(lock_path(journal))
    assert has_runner(journal)
    with pytest.raises(JournalError, match='another runner has'):
        FileLock(lock_path(journal))
    lock.close()
    assert not has_runner(journal)


def test_a_runner_starts_while_others_ask_whether_there_is_one(tmp_path: Path) -> None:
    journal = tmp_path / 'missions.db'
    over = threading.Event()

    def ask() -> None:
        while not over.is_set():
            has_runner(journal)

    askers = [threading.Thread(target=ask) for _ in range(2)]
    for asker in askers:
        asker.start()
    try:
        for _ in range(100):
            FileLock(lock_path(journal)).close()
    finally:
        over.set()
        for asker in askers:
            asker.join()
