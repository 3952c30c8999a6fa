"""Reads what each program in `programs` does wrong, and what goalwire has to say to it.

A program is a file, or `program.py` or `command.sh` in a folder with the files that it needs. It begins with
comments: what it does wrong, in one sentence, and then what is expected:

    # says: a piece of the sentence that is to be told
    # not: a piece of a sentence that would mislead
    # at: the file in whose line it is, if not in the line that is marked with `# <-- here`
    # within: seconds until then, if not WITHIN_S
    # arguments: of the command line
    # ctrl-c: the program goes on, and Ctrl-C ends it once it was told; `at 3 s`: it is told then
"""

from __future__ import annotations

from pathlib import Path

from goalwire.records import record

PROGRAMS = Path(__file__).parent / 'programs'
WITHIN_S = 2.0
_MARK = '# <-- here'


@record
class Mistake:
    """One program, and what is told about it."""

    name: str
    """As 'spinning/never_spun'."""
    file: Path
    title: str
    says: str
    never_says: str
    place: str
    """As 'never_spun.py:8', or a file's name; '' if it is told before any line is run."""
    within: float
    arguments: tuple[str, ...]
    ctrl_c: str


def read(file: Path) -> Mistake:
    """Return what a program's first lines say of it."""
    lines = file.read_text(encoding='utf-8').splitlines()
    head = [line.removeprefix('# ') for line in lines[: next(i for i, x in enumerate(lines) if x[:1] != '#')]]
    expected = dict(line.partition(': ')[::2] for line in head[1:])
    marked = [number for number, line in enumerate(lines, 1) if line.endswith(_MARK)]
    place = expected.get('at') or (f'{file.name}:{marked[0]}' if marked else '')
    own = file if file.parent.parent == PROGRAMS else file.parent
    return Mistake(
        name=own.relative_to(PROGRAMS).with_suffix('').as_posix(),
        file=file,
        title=head[0],
        says=expected.get('says', ''),
        never_says=expected.get('not', ''),
        place=place,
        within=float(expected.get('within', str(WITHIN_S)).removesuffix(' s')),
        arguments=tuple(expected.get('arguments', '').split()),
        ctrl_c=expected.get('ctrl-c', ''),
    )


def read_all() -> list[Mistake]:
    """Return all of them, by their names."""
    alone = PROGRAMS.glob('*/*.py')
    in_folders = (*PROGRAMS.glob('*/*/program.py'), *PROGRAMS.glob('*/*/command.sh'))
    return [read(file) for file in sorted((*alone, *in_folders))]
