"""Shared by the verbs of `mission`: the arguments for journal and mission, and how both are opened."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.errors import JournalError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator

    from goalwire.missions.journal_store import MissionRow, Store

DEFAULT = 'missions.db'


def add_journal_argument(parser: ArgumentParser) -> None:
    """Add --journal."""
    parser.add_argument(
        '-j',
        '--journal',
        metavar='FILE',
        type=Path,
        default=Path(DEFAULT),
        help=f'The file that the runner writes (default: {DEFAULT} in this folder)',
    )


def add_mission_arguments(parser: ArgumentParser) -> None:
    """Add --journal, and the argument for the mission's id."""
    add_journal_argument(parser)
    parser.add_argument('mission_id', metavar='ID', help='Id of the mission, or the beginning of the id')


@contextmanager
def open_journal(arguments: Namespace) -> Iterator[Store]:
    """Open the journal, which has to exist. Raises CommandError."""
    from goalwire.missions.journal_store import Store

    try:
        with Store(arguments.journal, must_exist=True) as store:
            yield store
    except JournalError as error:
        missing = not arguments.journal.exists()
        raise CommandError(Outcome.NOT_FOUND if missing else Outcome.UNAVAILABLE, str(error)) from None


def find_mission(store: Store, given: str) -> MissionRow:
    """Return the mission whose id is `given`, or else the only one whose id begins with it.

    Raises CommandError.
    """
    rows = store.missions()
    found = [row for row in rows if row.id == given] or [row for row in rows if row.id.startswith(given)]
    if len(found) == 1:
        return found[0]
    see = f'see: goalwire mission list -j {store.path}'
    if found:
        raise CommandError(Outcome.BAD_VALUE, f"{len(found)} missions begin with '{given}'", see)
    near = did_you_mean(get_close_matches(given, [row.id for row in rows], 3, 0.6))
    raise CommandError(Outcome.NOT_FOUND, f"there is no mission '{given}'", near or see)
