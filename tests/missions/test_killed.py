"""Runner and server are killed by SIGKILL at random moments, on real wires: no goal is executed twice."""

from __future__ import annotations

import os
import random
import sys
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS, require

from goalwire.missions.store import Store
from goalwire.missions.wakeup import wake_runner
from goalwire.rules.missions.entries import EntryKind, MissionState

PROGRAMS = Path(__file__).parent / 'programs'
KILLS = int(os.environ.get('GOALWIRE_TEST_MISSION_KILLS', '20'))
PLACES = KILLS


class World:
    """A server and a runner in processes, their files, and what a person does about lost goals."""

    def __init__(self, network: str, folder: Path) -> None:
        self.env = isolated_env(network)
        self.journal = folder / 'missions.db'
        self.executions = folder / 'executions.txt'
        self.questions = 0

    def base(self) -> Program:
        program = Program(PROGRAMS / 'base.py', str(self.executions), env=self.env)
        program.expect('^ready$')
        return program

    def runner(self) -> Program:
        mission = f'{PROGRAMS / "rounds.py"}:rounds'
        arguments = ('mission', 'run', '-j', str(self.journal), '--id', 'm', mission, str(PLACES))
        return Program(Path('-m'), 'goalwire', *arguments, env=self.env)

    def lines(self) -> list[list[str]]:
        if not self.executions.exists():
            return []
        return [line.split() for line in self.executions.read_text(encoding='utf-8').splitlines()]

    def answer_if_asked(self) -> None:
        """Decide about a lost goal as a person would who has seen the robot."""
        with Store(self.journal, must_exist=True) as store:
            row = store.mission('m')
            assert row is not None
            if row.state is not MissionState.LOST:
                return  # the question of an earlier life, which was answered there
            asked = [entry for entry in store.entries('m') if entry.kind is EntryKind.ASKED][-1]
            goal_id = asked.body['question'].split('goal ')[-1].split()[0]  # type: ignore[union-attr]
            was_reached = [goal_id, 'ended'] in [line[:2] for line in self.lines()]
            answer = 'done' if was_reached else 'again'
            store.command('m', 'decide', {'step': asked.step, 'answer': answer})
            wake_runner(store)
        self.questions += 1


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize('network', ['rmw_zenoh_cpp', DDS])
def test_no_goal_is_executed_twice_whoever_is_killed(network: str, tmp_path: Path) -> None:
    require(network)
    world = World(network, tmp_path)
    chance = random.Random(sys.version)
    with ExitStack() as stack:
        base, runner = stack.enter_context(world.base()), stack.enter_context(world.runner())
        for _ in range(KILLS):
            runner.expect('begins|asks|^Mission: m$')
            time.sleep(chance.random() * 1.5)  # any moment will do
            if chance.random() < 0.3:
                base.kill()
                base.wait()
                base = stack.enter_context(world.base())
            runner.kill()
            runner.wait()
            runner = stack.enter_context(world.runner())
        while 'asks' in runner.expect('asks: .*may have run|^Mission succeeded|^goalwire: ', 600.0)[0]:
            world.answer_if_asked()
        assert runner.wait() == 0, runner.output
    begun = Counter(line[0] for line in world.lines() if line[1] == 'begun')
    assert set(begun.values()) == {1}
    assert all(line[2] == '0' for line in world.lines()), 'a server got an id that it knew'
    assert len(begun) >= PLACES - world.questions
