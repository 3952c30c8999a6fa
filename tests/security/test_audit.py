"""The audit log: what is written stays as it was, or it is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.processes import Program

from goalwire.errors import SecurityError
from goalwire.security.audit import append, log_path, read


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = log_path(tmp_path, 'robby')
    for number in range(5):
        append(path, {'who': 'mallory', 'number': str(number)})
    return path


def test_entries_are_read_in_their_order(log: Path) -> None:
    assert [entry['number'] for entry in read(log)] == list('01234')


@pytest.mark.parametrize('at', range(4))
@pytest.mark.parametrize('how', ['changed', 'taken out', 'put in'])
def test_a_line_that_was_tampered_with_is_found(log: Path, at: int, how: str) -> None:
    lines = log.read_bytes().splitlines(keepends=True)
    if how == 'changed':
        lines[at] = lines[at].replace(b'mallory', b'alice')
    elif how == 'taken out':
        del lines[at]
    else:
        lines.insert(at, lines[at])
    log.write_bytes(b''.join(lines))
    with pytest.raises(SecurityError, match=rf'robby.log:{at + 1 + (how != "taken out")}: the line before'):
        list(read(log))


def test_a_line_that_lost_power_has_cut_off_is_told_and_others_follow(log: Path) -> None:
    with log.open('ab') as stream:
        stream.write(b'{"who": "mal')
    append(log, {'who': 'eve', 'number': '6'})
    entries = read(log)
    assert [next(entries)['number'] for _ in range(5)] == list('01234')
    with pytest.raises(SecurityError, match=r'robby.log:6: this line is damaged'):
        next(entries)
    assert log.read_bytes().endswith(b'\n')


@pytest.mark.slow
def test_programs_with_one_identity_share_a_log(log: Path) -> None:
    source = """
        import sys
        from pathlib import Path
        from goalwire.security.audit import append
        for number in range(50):
            append(Path(sys.argv[1]), {'who': sys.argv[2]})
    """
    with Program(source, str(log), 'a') as one, Program(source, str(log), 'b') as two:
        one.succeed()
        two.succeed()
    written = [entry['who'] for entry in read(log)]
    assert (written.count('a'), written.count('b'), len(written)) == (50, 50, 105)
