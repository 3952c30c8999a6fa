"""The progress of a goal: the option `--progress FIELD[/MAX]`, and a bar."""

from __future__ import annotations

from argparse import ArgumentParser

from goalwire.observe.progress import Progress

_WIDTH = 30


def progress_argument(parser: ArgumentParser, more_help: str = '') -> None:
    """Add `--progress`."""
    parser.add_argument(
        '--progress',
        metavar='FIELD[/MAX]',
        help='Draw a bar on a terminal from a field of the feedback: a part of 1, or of MAX as in FIELD/MAX; '
        'of an array its length counts. A field that says what remains begins at nothing done' + more_help,
    )


def check_field(spec: str | None) -> None:
    """Raise ProgressError if `--progress` cannot be read, before anything is sent."""
    if spec:
        Progress(spec)


def bar(done: float) -> str:
    """Return a progress bar for a terminal; `done` goes from 0 to 1."""
    full = round(done * _WIDTH)
    return f'{"█" * full}{"░" * (_WIDTH - full)} {done * 100:3.0f} %'
