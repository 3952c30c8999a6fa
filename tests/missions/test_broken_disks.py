"""The journal's disk is full, read-only or gone: no further goal begins, and the runner says why."""

from __future__ import annotations

import subprocess
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program

PROGRAMS = Path(__file__).parent / 'programs'
PLACES = 6


class World:
    """A server, a disk for the runner's journal, and runners one after the other."""

    def __init__(self, disk: Path, folder: Path) -> None:
        self.env = isolated_env('rmw_zenoh_cpp')
        self.disk = disk
        self.executions = folder / 'executions.txt'

    def base(self) -> Program:
        program = Program(PROGRAMS / 'base.py', str(self.executions), '0.5', '5.0', env=self.env)
        program.expect('^ready$')
        return program

    def runner(self) -> Program:
        mission = f'{PROGRAMS / "rounds.py"}:rounds'
        journal = str(self.disk / 'missions.db')
        arguments = ('mission', 'run', '-j', journal, '--id', 'm', mission, str(PLACES))
        return Program(Path('-m'), 'goalwire', *arguments, env=self.env)

    def executed(self) -> Counter[str]:
        lines = self.executions.read_text(encoding='utf-8').splitlines()
        return Counter(line.split()[0] for line in lines if ' begun ' in line)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 1 MB, in memory."""
    folder = tmp_path / 'disk'
    folder.mkdir()
    command = ['mount', '-t', 'tmpfs', '-o', 'size=1m', 'tmpfs', str(folder)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip('only root may mount a small disk')
    yield folder
    subprocess.run(['umount', '--lazy', str(folder)], check=True)


def fill(disk: Path) -> None:
    """Take all space that is left."""
    with suppress(OSError), (disk / 'filler').open('wb', buffering=0) as filler:
        for size in (4096, 1):
            with suppress(OSError):
                while True:
                    filler.write(b'x' * size)


@pytest.mark.slow
def test_on_a_full_disk_no_further_goal_begins(small_disk: Path, tmp_path: Path) -> None:
    world = World(small_disk, tmp_path)
    with world.base():
        with world.runner() as runner:
            runner.expect('step 2: goal drive begins')
            fill(small_disk)
            runner.expect('cannot be written: .*; look at the disk, its free space')
            assert runner.wait() not in {0, None}
        assert len(world.executed()) == 2
        with world.runner() as refused:
            refused.expect('cannot be .*look at the disk')
            assert refused.wait() not in {0, None}
        (small_disk / 'filler').unlink()
        with world.runner() as again:
            again.expect('^Mission succeeded')
            assert again.wait() == 0
    assert len(world.executed()) == PLACES
    assert set(world.executed().values()) == {1}


@pytest.mark.slow
def test_on_a_disk_that_became_read_only_no_goal_begins(small_disk: Path, tmp_path: Path) -> None:
    world = World(small_disk, tmp_path)
    with world.base():
        with world.runner() as runner:
            runner.expect('step 2: goal drive begins')
            runner.kill()
            runner.wait()
        subprocess.run(['mount', '-o', 'remount,ro', str(small_disk)], check=True)
        with world.runner() as refused:
            refused.expect('cannot be ')
            assert refused.wait() not in {0, None}
            assert 'Traceback' not in refused.output
        assert len(world.executed()) <= 2  # the runner may have died before it sent the second


@pytest.mark.slow
def test_after_its_journal_was_deleted_no_further_goal_begins(tmp_path: Path) -> None:
    world = World(tmp_path, tmp_path)
    with world.base(), world.runner() as runner:
        runner.expect('step 2: goal drive begins')
        for file in tmp_path.glob('missions.db*'):
            file.unlink()
        runner.expect('was deleted or replaced')
        assert runner.wait() not in {0, None}
        assert 'Traceback' not in runner.output
    assert len(world.executed()) == 2
