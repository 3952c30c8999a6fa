"""Runner and server are killed by SIGKILL at random moments, on real wires: each goal is executed once.

`GOALWIRE_TEST_MISSION_KILLS=300 make long` kills that often in each case. The server notes each execution in
a file of its own, and a tap notes each goal on the wire; on DDS the tap needs root. Pytest's `--junitxml FILE
-o junit_family=xunit1` writes the figures down.
"""

from __future__ import annotations

import os
import socket
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from uuid import uuid4

import pytest
from helpers.chance import fresh_chance
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS, require

from goalwire.missions.store import Store
from goalwire.missions.wakeup import wake_runner
from goalwire.rules.missions.entries import EntryKind, MissionState

PROGRAMS = Path(__file__).parent / 'programs'
ZENOH = 'rmw_zenoh_cpp'
TAPS = {ZENOH: 'tap.py', DDS: 'tap_dds.py'}
KILLS = int(os.environ.get('GOALWIRE_TEST_MISSION_KILLS', '20'))
PLACES = 2 * KILLS
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
    """A server and a runner in processes, their files, and a person who decides about lost goals."""

    def __init__(self, network: str, folder: Path, *, is_journalled: bool, stack: ExitStack) -> None:
        self.env = isolated_env(network)
        self.journal = folder / 'missions.db'
        self.executions = folder / 'executions.txt'
        self.heard = folder / 'heard.txt'
        self.kills = 0
        self._last_step = 0
        self._goals = (str(folder / 'drive.goals'),) if is_journalled else ()
        self._stack = stack
        self.is_tapped = network == ZENOH or may_read_packets()
        if self.is_tapped:
            self._start(PROGRAMS / TAPS[network], str(self.heard)).expect('^ready$')
        self.start_base()
        self.start_runner()

    def _start(self, *command: Path | str) -> Program:
        source, *arguments = command
        return self._stack.enter_context(Program(Path(source), *map(str, arguments), env=self.env))

    def start_base(self) -> None:
        """Start the server."""
        self.base = self._start(PROGRAMS / 'base.py', str(self.executions), *self._goals)
        self.base.expect('^ready$')

    def start_runner(self) -> None:
        """Start the runner of the mission."""
        mission = f'{PROGRAMS / "rounds.py"}:rounds'
        arguments = ('mission', 'run', '-j', str(self.journal), '--id', 'm', mission, str(PLACES))
        self.runner = self._start('-m', 'goalwire', *arguments)

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


@contextmanager
def world_of(network: str, folder: Path, *, is_journalled: bool) -> Iterator[World]:
    """Yield a world in which everything runs; at the end everything is killed."""
    require(network)
    with ExitStack() as stack:
        yield World(network, folder, is_journalled=is_journalled, stack=stack)


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
    assert sorted(goals) == list(range(PLACES)), 'a step has no goal'
    assert set(begun.values()) == {1}, 'a goal was executed twice'
    assert set(begun) <= {each for ids in goals.values() for each in ids}, 'a goal is in no journal'
    for step, ids in goals.items():
        # A person has said "again" about a goal only if the server had not ended it.
        assert [ended[each] for each in ids] == [0] * (len(ids) - 1) + [1], f'step {step + 1}: {ids}'
    assert all(line[2] == '0' for line in lines), 'a server got an id that it knew'


def assert_none_was_sent_to_a_server_that_knew_it(world: World) -> None:
    """Compare the goals on the wire with the server's file of executions."""
    begun = {line[0]: float(line[3]) for line in world.lines(world.executions) if line[1] == 'begun'}
    sent: dict[tuple[str, str], float] = {}
    for goal_id, sample, at in world.lines(world.heard):
        sent.setdefault((goal_id, sample), float(at))
    assert set(begun) <= {goal_id for goal_id, _ in sent}, 'the tap has missed goals'
    late = [goal for goal, at in sent.items() if goal[0] in begun and at > begun[goal[0]] + PROMPT_S]
    assert not late, 'a goal was sent that a server had executed'


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize('victims', ['client', 'server', 'both'])
@pytest.mark.parametrize('server', ['stock', 'journalled'])
@pytest.mark.parametrize('network', [ZENOH, DDS])
def test_each_goal_is_executed_once_whoever_is_killed(
    network: str,
    server: str,
    victims: str,
    tmp_path: Path,
    record_property: Callable[[str, object], None],
) -> None:
    chance = fresh_chance(record_property)
    with world_of(network, tmp_path, is_journalled=server == 'journalled') as world:
        for _ in range(KILLS):
            if 'succeeded' in world.follow(to_next_step=chance.random() < 0.7):
                break
            time.sleep(chance.random())  # any moment will do
            world.kill(victims)
        while 'begins' in (line := world.follow(to_next_step=True)):
            pass
        assert 'succeeded' in line
        assert world.runner.wait() == 0, world.runner.output
    record_property('kills', world.kills)
    record_property('questions', world.questions())
    record_property('tapped', world.is_tapped)
    assert_each_was_executed_once(world)
    if world.is_tapped:
        assert_none_was_sent_to_a_server_that_knew_it(world)
    assert world.kills >= KILLS * 0.8


@pytest.mark.slow
@pytest.mark.parametrize('network', [ZENOH, pytest.param(DDS, marks=pytest.mark.long)])
def test_an_order_that_is_sent_again_after_its_runner_was_killed_is_carried_out_once(
    network: str, tmp_path: Path
) -> None:
    require(network)
    env, executions, order = isolated_env(network), tmp_path / 'executions.txt', str(uuid4())
    with ExitStack() as stack:

        def start(*command: Path | str) -> Program:
            source, *arguments = command
            return stack.enter_context(Program(Path(source), *map(str, arguments), env=env))

        def send() -> Program:
            return start('-m', 'goalwire', 'action', 'send_goal', 'fetch', 'order=3', '--goal-id', order)

        start(PROGRAMS / 'base.py', executions).expect('^ready$')
        for _ in range(2):
            runner = start(PROGRAMS / 'orders.py', tmp_path / 'missions.db')
            runner.expect('^ready$')
            sent = send()
            sent.expect('^Goal accepted', IN_TIME)
            runner.kill()  # on a busy machine the mission may have ended before
            runner.wait()
            sent.wait()
        start(PROGRAMS / 'orders.py', tmp_path / 'missions.db').expect('^ready$')
        send().expect('^Goal finished with status: SUCCEEDED', IN_TIME)
        again = send()
        again.expect('nothing is sent', IN_TIME)
        again.expect('^Goal finished with status: SUCCEEDED', IN_TIME)
    assert executions.read_text(encoding='utf-8').count('begun') == 1
