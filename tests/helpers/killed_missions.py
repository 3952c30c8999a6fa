"""A mission whose runner and server are killed at random moments, and what must hold about its goals then."""

from __future__ import annotations

import random
import socket
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from helpers.processes import Program

from goalwire.missions.store import Store
from goalwire.missions.wakeup import wake_runner
from goalwire.rules.missions.entries import EntryKind, MissionState

_EVENTS = r'asks: .*may have run|step (?P<step>\d+): goal drive begins|^Mission succeeded|^goalwire: '
PROMPT_S = 1.0
"""A goal that is heard on the wire later than this after its execution began was sent again."""
IN_TIME = 600.0


def may_read_packets() -> bool:
    """Return whether this process may read the packets of the loopback interface."""
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW).close()
    except (AttributeError, PermissionError):  # not on Linux, or not root
        return False
    return True


class World:
    """A server and a runner in processes, their files, and a person who decides about lost goals.

    `start_base` starts the server, which writes its executions into the file that it is given. `tap` is the
    program that writes down the goals on the wire, if there is one. `mission` is the file of the mission
    `rounds`, which drives to as many places as it is given.
    """

    def __init__(
        self,
        folder: Path,
        stack: ExitStack,
        *,
        start_base: Callable[[Path], Program],
        mission: Path,
        places: int,
        env: Mapping[str, str],
        tap: Path | None,
    ) -> None:
        self.journal = folder / 'missions.db'
        self.executions = folder / 'executions.txt'
        self.heard = folder / 'heard.txt'
        self.places = places
        self.kills = 0
        self.is_tapped = tap is not None
        self._last_step = 0
        self._stack = stack
        self._env = env
        self._mission = mission
        self._start_base = start_base
        if tap is not None:
            stack.enter_context(Program(tap, str(self.heard), env=env)).expect('^ready$')
        self.start_base()
        self.start_runner()

    def start_base(self) -> None:
        """Start the server."""
        self.base = self._stack.enter_context(self._start_base(self.executions))
        self.base.expect('^ready$')

    def start_runner(self) -> None:
        """Start the runner of the mission."""
        arguments = ('-j', str(self.journal), '--id', 'm', f'{self._mission}:rounds', str(self.places))
        runner = Program(Path('-m'), 'goalwire', 'mission', 'run', *arguments, env=self._env)
        self.runner = self._stack.enter_context(runner)

    def kill(self, victims: str) -> None:
        """Kill the client, the server, or both, and start them again."""
        self.kills += 1
        if victims != 'client':
            self.base.kill()
            self.base.wait()
        if victims != 'server':
            self.runner.kill()
            self.runner.wait()
        if victims != 'client':
            self.start_base()
        if victims != 'server':
            self.start_runner()

    def kill_often(self, victims: str, times: int, chance: random.Random) -> None:
        """Kill at random moments, up to so many times, and wait until the mission has succeeded."""
        for _ in range(times):
            if 'succeeded' in self.follow(to_next_step=chance.random() < 0.7):
                break
            time.sleep(chance.random())  # any moment will do
            self.kill(victims)
        while 'begins' in (line := self.follow(to_next_step=True)):
            pass
        assert 'succeeded' in line
        assert self.runner.wait() == 0, self.runner.output

    def lines(self, path: Path) -> list[list[str]]:
        """Return the words of a file's lines."""
        return [line.split() for line in path.read_text(encoding='utf-8').splitlines()]

    def answer_if_asked(self) -> None:
        """Decide about a lost goal as a person would who has seen the robot."""
        with Store(self.journal, must_exist=True) as store:
            row = store.mission('m')
            assert row is not None
            if row.state is not MissionState.LOST:
                return  # the question of an earlier life, which was answered there
            asked = [entry for entry in store.entries('m') if entry.kind is EntryKind.ASKED][-1]
            goal_id = asked.body['question'].split('goal ')[-1].split()[0]  # type: ignore[union-attr]
            was_reached = [goal_id, 'ended'] in [line[:2] for line in self.lines(self.executions)]
            answer = 'done' if was_reached else 'again'
            store.command('m', 'decide', {'step': asked.step, 'answer': answer})
            wake_runner(store)

    def questions(self) -> int:
        """Return how many questions the mission has asked; each life of a runner repeats those before it."""
        with Store(self.journal, must_exist=True) as store:
            return sum(entry.kind is EntryKind.ASKED for entry in store.entries('m'))

    def follow(self, *, to_next_step: bool) -> str:
        """Wait until the mission begins a step or ends, and answer its questions. Return the runner's line.

        A runner that was started again first repeats what its mission has done. So with `to_next_step` lines
        about steps that had begun before are passed over.
        """
        while True:
            found = self.runner.expect(_EVENTS, IN_TIME)
            if 'asks: ' in found[0]:
                self.answer_if_asked()
            elif not found['step'] or not to_next_step or int(found['step']) > self._last_step:
                self._last_step = max(self._last_step, int(found['step'] or 0))
                return found[0]


def goals_by_step(journal: Path) -> dict[int, list[str]]:
    """Return the ids under which the mission has sent each of its goals, in their order."""
    goals: dict[int, list[str]] = {}
    with Store(journal, must_exist=True) as store:
        for entry in store.entries('m'):
            if entry.kind is EntryKind.INTENT:
                goals.setdefault(entry.step, []).append(str(entry.body['goal_id']))
    return goals


def assert_each_was_executed_once(world: World) -> None:
    """Compare the goals of the mission, which has succeeded, with the server's file of executions."""
    lines = world.lines(world.executions)
    begun = Counter(line[0] for line in lines if line[1] == 'begun')
    ended = Counter(line[0] for line in lines if line[1] == 'ended')
    goals = goals_by_step(world.journal)
    assert sorted(goals) == list(range(world.places)), 'a step has no goal'
    assert set(begun.values()) == {1}, 'a goal was executed twice'
    assert set(begun) <= {each for ids in goals.values() for each in ids}, 'a goal is in no journal'
    for step, ids in goals.items():
        # A person has said "again" about a goal only if the server had not ended it.
        assert [ended[each] for each in ids] == [0] * (len(ids) - 1) + [1], f'step {step + 1}: {ids}'


def assert_none_was_sent_to_a_server_that_knew_it(world: World) -> None:
    """Compare the goals on the wire with the server's file of executions."""
    begun = {line[0]: float(line[3]) for line in world.lines(world.executions) if line[1] == 'begun'}
    sent: dict[tuple[str, str], float] = {}
    for goal_id, sample, at in world.lines(world.heard):
        sent.setdefault((goal_id, sample), float(at))
    assert set(begun) <= {goal_id for goal_id, _ in sent}, 'the tap has missed goals'
    late = [goal for goal, at in sent.items() if goal[0] in begun and at > begun[goal[0]] + PROMPT_S]
    assert not late, 'a goal was sent that a server had executed'
