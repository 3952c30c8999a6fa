"""The audit log: what is written stays as it was, or it is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.processes import Program

from goalwire.errors import SecurityError
from goalwire.security import audit
from goalwire.security.audit import append, log_path, put_aside, read


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


@pytest.fixture
def aside(log: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Make the log so long that four files are put aside, each with two entries or more."""
    monkeypatch.setattr(audit, 'PUT_ASIDE_AT', 250)
    number = 5
    while len(put_aside(log)) < 4:
        append(log, {'who': 'mallory', 'number': str(number)})
        number += 1
    return list(put_aside(log).values())


def test_entries_are_read_across_the_files_that_were_put_aside(log: Path, aside: list[Path]) -> None:
    assert [each.name for each in aside] == [f'robby.log.{number}' for number in (1, 2, 3, 4)]
    numbers = [int(entry['number']) for entry in read(log)]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) > 10


def test_what_is_tampered_with_in_a_file_that_was_put_aside_is_found(log: Path, aside: list[Path]) -> None:
    content = aside[1].read_bytes()
    last = content.splitlines(keepends=True)[-1]
    aside[1].write_bytes(content.removesuffix(last))
    with pytest.raises(SecurityError, match=r'robby.log.3:1: the line before this one was changed'):
        list(read(log))
    aside[1].unlink()
    with pytest.raises(SecurityError, match=r'robby.log.3:1: the line before this one was changed'):
        list(read(log))


def test_the_oldest_files_are_deleted_and_the_rest_still_fits(
    log: Path, aside: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(audit, 'KEPT', 3)
    while 6 not in put_aside(log):
        append(log, {'who': 'mallory', 'number': 'x'})
    assert list(put_aside(log)) == [4, 5, 6]
    assert aside[-1].exists()
    assert [entry['number'] for entry in read(log)][-1] == 'x'


def test_power_lost_between_two_files_leaves_the_chain_whole(log: Path, aside: list[Path]) -> None:
    """The log was put aside, and the next one not yet begun."""
    log.rename(log.with_name('robby.log.5'))
    before = len(list(read(log)))
    append(log, {'who': 'eve', 'number': 'last'})
    assert len(list(read(log))) == before + 1
    assert len(aside) == 4


@pytest.mark.slow
def test_programs_with_one_identity_share_a_log(log: Path) -> None:
    source = """
        import sys
        from pathlib import Path
        from goalwire.security import audit
        audit.PUT_ASIDE_AT = 1000  # while one program writes, the other may put the file aside
        audit.KEPT = 1000
        for number in range(50):
            audit.append(Path(sys.argv[1]), {'who': sys.argv[2]})
    """
    with Program(source, str(log), 'a') as one, Program(source, str(log), 'b') as two:
        one.succeed()
        two.succeed()
    written = [entry['who'] for entry in read(log)]
    assert (written.count('a'), written.count('b'), len(written)) == (50, 50, 105)
