"""A mission whose runner and server are killed at random moments, and what must hold about its goals then."""

from __future__ import annotations

import random
import signal
import socket
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from helpers.forking import ForkServer
from helpers.processes import Program

import goalwire
from goalwire.missions.journal_store import Store
from goalwire.missions.wakeup import wake_runner
from goalwire.rules.missions.entries import EntryKind, MissionState

_EVENTS = r'asks: .*may have run|step (?P<step>\d+): goal drive begins|^Mission succeeded|^goalwire: '
PROMPT_S = 1.0
"""A goal that is heard on the wire later than this after its execution began was sent again."""
IN_TIME = 600.0
PRELOADED = (
    'example_interfaces.action',
    'goalwire.apps.cli.commands.mission.run',
    'goalwire.apps.cli.framework.live',
    'goalwire.apps.cli.main',
    'goalwire.entities.actions.journal_file',
    'goalwire.missions.runner',
    'goalwire.transport.dds',
    'goalwire.transport.zenoh',
    'yaml',
)
"""The modules of the runner and of the server in tests/missions/programs, for the process that forks them."""
_GOALWIRE = Path(goalwire.__file__).with_name('__main__.py')


def may_read_packets() -> bool:
    """Return whether this process may read the packets of the loopback interface."""
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW).close()
    except (AttributeError, PermissionError):  # not on Linux, or not root
        return False
    return True


def ports_of(*domains: str) -> tuple[str, str]:
    """Return the first and the last port of RTPS in these domains, for the tap of packets."""
    numbers = [int(each) for each in domains]
    return str(7400 + 250 * min(numbers)), str(7400 + 250 * max(numbers) + 249)


class World:
    """A server and a runner in processes, their files, and a person who decides about lost goals.

    `start_base` starts the server, which writes its executions into the file that it is given. `mission` is
    the file of the mission `rounds`, which drives to as many places as it is given; when it has succeeded,
    the next one begins, so that a journal does not become long. `heard` is the file of a tap that writes down
    the goals on the wire, if there is one. A `server` forks the runners. A kill follows the beginning of a
    step by up to `within` s.
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
        heard: Path | None = None,
        server: ForkServer | None = None,
        within: float = 1.0,
    ) -> None:
        self.journal = folder / 'missions.db'
        self.executions = folder / 'executions.txt'
        self.heard = heard
        self.places = places
        self.kills = 0
        self.killed_at: list[float] = []
        """When runners were killed, by the clock that the server and the tap use."""
        self.missions = 1
        self._last_step = 0
        self._stack = stack
        self._env = env
        self._mission = mission
        self._start_base = start_base
        self._server = server
        self._within = within
        self.start_base()
        self.start_runner()

    def start_base(self) -> None:
        """Start the server."""
        self.base = self._stack.enter_context(self._start_base(self.executions))
        self.base.expect('^ready$')

    def start_runner(self) -> None:
        """Start the runner of the mission."""
        name = f'm{self.missions}'
        arguments = ('-j', str(self.journal), '--id', name, f'{self._mission}:rounds', str(self.places))
        source, *first = (Path('-m'), 'goalwire') if self._server is None else (_GOALWIRE,)
        runner = Program(
            Path(source), *map(str, first), 'mission', 'run', *arguments, env=self._env, server=self._server
        )
        self.runner = self._stack.enter_context(runner)

    def kill(self, victims: str) -> None:
        """Kill the client, the server, or both, and start them again.

        A runner whose mission ends at this moment is not killed; that does not count.
        """
        was_killed = True
        if victims != 'client':
            self.base.kill()
            self.base.wait()
            self.base.close()
        if victims != 'server':
            self.runner.kill()
            self.killed_at.append(time.monotonic())
            was_killed = self.runner.wait() == -signal.SIGKILL
            self.runner.close()
        if victims != 'client':
            self.start_base()
        if victims != 'server' and was_killed:
            self.start_runner()
        self.kills += was_killed

    def kill_often(self, victims: str, times: int, chance: random.Random) -> None:
        """Kill so many times at random moments, and wait until the last mission has succeeded."""
        while self.kills < times:
            if self.follow(to_next_step=chance.random() < 0.7):
                time.sleep(self._within * chance.random())  # any moment will do
                self.kill(victims)
            else:
                self.missions += 1
                self.start_runner()
        while self.follow(to_next_step=True):
            pass

    def lines(self, path: Path) -> list[list[str]]:
        """Return the words of a file's lines."""
        return [line.split() for line in path.read_text(encoding='utf-8').splitlines()]

    def answer_if_asked(self) -> None:
        """Decide about a lost goal as a person would who has seen the robot."""
        with Store(self.journal, must_exist=True) as store:
            id_ = f'm{self.missions}'
            row = store.mission(id_)
            assert row is not None
            if row.state is not MissionState.LOST:
                return  # the question of an earlier life, which was answered there
            asked = [entry for entry in store.entries(id_) if entry.kind is EntryKind.ASKED][-1]
            goal_id = asked.body['question'].split('goal ')[-1].split()[0]  # type: ignore[union-attr]
            was_reached = [goal_id, 'ended'] in [line[:2] for line in self.lines(self.executions)]
            answer = 'done' if was_reached else 'again'
            store.command(id_, 'decide', {'step': asked.step, 'answer': answer})
            wake_runner(store)

    def questions(self) -> int:
        """Return how many questions were asked; each life of a runner repeats those before it."""
        with Store(self.journal, must_exist=True) as store:
            return sum(
                entry.kind is EntryKind.ASKED for row in store.missions() for entry in store.entries(row.id)
            )

    def follow(self, *, to_next_step: bool) -> bool:
        """Wait until the mission begins a step, and answer its questions. Return False if it has succeeded.

        A runner that was started again first repeats what its mission has done. So with `to_next_step` lines
        about steps that had begun before are passed over.
        """
        while True:
            found = self.runner.expect(_EVENTS, IN_TIME)
            if 'asks: ' in found[0]:
                self.answer_if_asked()
            elif 'succeeded' in found[0]:
                assert self.runner.wait() == 0, self.runner.output
                self.runner.close()
                self._last_step = 0
                return False
            else:
                assert found['step'], self.runner.output
                if not to_next_step or int(found['step']) > self._last_step:
                    self._last_step = max(self._last_step, int(found['step']))
                    return True


def goals_by_step(journal: Path) -> dict[tuple[str, int], list[str]]:
    """Return the ids under which each mission has sent each of its goals, in their order."""
    goals: dict[tuple[str, int], list[str]] = {}
    with Store(journal, must_exist=True) as store:
        for row in store.missions():
            assert row.state is MissionState.SUCCEEDED, f'mission {row.id}: {row.state}: {row.why}'
            for entry in store.entries(row.id):
                if entry.kind is EntryKind.INTENT:
                    goals.setdefault((row.id, entry.step), []).append(str(entry.body['goal_id']))
    return goals


def assert_each_was_executed_once(world: World) -> None:
    """Compare the goals of the missions, which have succeeded, with the server's file of executions."""
    lines = world.lines(world.executions)
    begun = Counter(line[0] for line in lines if line[1] == 'begun')
    ended = Counter(line[0] for line in lines if line[1] == 'ended')
    goals = goals_by_step(world.journal)
    steps = {(f'm{mission + 1}', step) for mission in range(world.missions) for step in range(world.places)}
    assert set(goals) == steps, 'a step has no goal'
    assert set(begun.values()) == {1}, 'a goal was executed twice'
    assert set(begun) <= {each for ids in goals.values() for each in ids}, 'a goal is in no journal'
    for step, ids in goals.items():
        # A person has said "again" about a goal only if the server had not ended it.
        assert [ended[each] for each in ids] == [0] * (len(ids) - 1) + [1], f'{step}: {ids}'


def assert_none_was_sent_to_a_server_that_knew_it(world: World) -> None:
    """Compare the goals on the wire with the server's file of executions.

    A goal that was sent again since it never arrived is on the wire twice; the server began it when the
    second one came, not the first.
    """
    assert world.heard is not None
    begun = {line[0]: float(line[3]) for line in world.lines(world.executions) if line[1] == 'begun'}
    sent: dict[str, dict[str, float]] = {}
    for goal_id, sample, heard in world.lines(world.heard):
        sent.setdefault(goal_id, {}).setdefault(sample, float(heard))
    missed = [at for goal_id, at in begun.items() if goal_id not in sent]
    # A runner of Zenoh may be killed after it has sent to the server, and before it has sent to the tap.
    killed = [at for at in missed if any(abs(at - kill) < PROMPT_S for kill in world.killed_at)]
    assert missed == killed, 'the tap has missed goals'
    for goal_id, at in begun.items():
        if goal_id not in sent:
            continue
        times = sent[goal_id].values()
        latest = max(times)
        assert latest <= at + PROMPT_S, f'goal {goal_id} was sent that a server had executed'
        executed = min(times, key=lambda time: abs(time - at))
        assert latest == executed, f'goal {goal_id} was sent again although a server had it'
