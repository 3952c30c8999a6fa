"""--robot on the commands, and goalwire fleet: who is there, and one goal for many robots."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import Begin, CommandLine, Ended, on_dds_too
from helpers.forking import ForkServer
from helpers.processes import Program
from helpers.programs import programs_in

PROGRAMS = Path(__file__).parents[1] / 'programs'
MISSING = "there is no robot 'betta'; did you mean 'beta'? see: goalwire fleet list\n"


@pytest.fixture(scope='module')
def robots(world: dict[str, str]) -> Iterator[Program]:
    """The robots of programs/robots.py, running."""
    with programs_in(world, PROGRAMS) as start:
        program = start('robots')
        program.expect('^ready$')
        yield program


class Goalwire:
    """`goalwire` beside the robots."""

    def __init__(self, run: CommandLine) -> None:
        self._run = run

    def __call__(self, line: str, **variables: str) -> Ended:
        return self._run(*line.split(), program='goalwire', **variables)

    def ok(self, line: str, **variables: str) -> str:
        """Run a command that succeeds, and return what it prints."""
        ended = self(line, **variables)
        assert ended.code == 0, ended.err
        return ended.out


@pytest.fixture
def goalwire(world: dict[str, str], robots: Program, commands: ForkServer, tmp_path: Path) -> Goalwire:
    return Goalwire(CommandLine({**world, 'XDG_STATE_HOME': str(tmp_path)}, server=commands))


@on_dds_too
def test_the_robots_are_listed_by_their_namespaces(goalwire: Goalwire) -> None:
    assert goalwire.ok('fleet list') == 'albert\nalpha\nbeta\n'
    assert goalwire.ok('fleet list -r al* --count') == '2\n'
    assert json.loads(goalwire.ok('fleet list -r beta --json')) == {'robot': 'beta', 'nodes': 1}
    ended = goalwire('fleet list -r betta')
    assert (ended.code, ended.err) == (3, f'goalwire: {MISSING}')


def test_a_command_sees_one_robot_and_its_names(goalwire: Goalwire) -> None:
    assert goalwire.ok('node list --robot beta') == '/beta/driver\n'
    assert goalwire.ok('action list', GOALWIRE_ROBOT='alpha') == '/alpha/drive\n'
    assert goalwire.ok('topic echo --robot alpha --once text') == 'data: I am alpha\n---\n'
    assert goalwire.ok('topic echo --robot alpha --once /alpha/text') == 'data: I am alpha\n---\n'
    assert goalwire.ok('action info drive --robot beta').startswith('Action: /beta/drive\n')
    assert 'status: SUCCEEDED' in goalwire.ok('action send_goal drive order=1 --robot beta')
    assert goalwire('topic echo --once --robot alpha /beta/text').code == 3


@pytest.mark.parametrize('line', ['node list', 'topic pub --once text std_msgs/String data=x'])
def test_a_robot_that_is_not_there_is_told_before_anything_is_sent(goalwire: Goalwire, line: str) -> None:
    ended = goalwire(line, GOALWIRE_ROBOT='betta')
    assert (ended.code, ended.out, ended.err) == (3, '', f'goalwire: {MISSING}')


def test_a_name_that_no_robot_can_have_is_refused(goalwire: Goalwire) -> None:
    ended = goalwire('node list --robot a*')
    assert ended.code == 4
    assert "'a*' is not a name of a robot" in ended.err


def test_status_is_a_table_or_a_document_for_each(goalwire: Goalwire) -> None:
    head, *lines = goalwire.ok('fleet status -r al*').splitlines()
    assert head.split() == ['ROBOT', 'STATE', 'BATTERY', 'GOALS', 'NODES']
    assert [line.split() for line in lines] == [
        [name, 'idle', '50', '%', '0', '1'] for name in ('albert', 'alpha')
    ]
    [beta] = map(json.loads, goalwire.ok('fleet status -r beta --json').splitlines())
    assert (beta['robot'], beta['battery'], beta['stopped']) == ('beta', 0.5, None)


def test_one_goal_for_many_robots_and_one_table(goalwire: Goalwire, tmp_path: Path) -> None:
    head, *lines = goalwire.ok('fleet send drive order=4 -r *').splitlines()
    assert head.split() == ['ROBOT', 'STATUS', 'GOAL']
    assert [line.split()[:2] for line in lines] == [
        [name, 'SUCCEEDED'] for name in ('albert', 'alpha', 'beta')
    ]
    assert not list((tmp_path / 'goalwire' / 'jobs').iterdir()), 'the journal of a job that is done stays'


def test_a_repeated_job_sends_no_goal_twice(goalwire: Goalwire, tmp_path: Path) -> None:
    job = f'--job {tmp_path / "job.db"} --json'
    first = goalwire(f'fleet send drive order=13 -r alpha {job}')
    assert first.code == 1
    report = json.loads(first.out)
    assert (report['status'], report['robot']) == ('ABORTED', 'alpha')
    again = goalwire(f'fleet send drive order=13 -r al* {job}')
    assert report in map(json.loads, again.out.splitlines())
    other = goalwire(f'fleet send drive order=14 -r alpha {job}')
    assert 'belongs to another action, goal or timeout: name another file' in other.err


def test_what_cannot_be_sent_is_told_before(goalwire: Goalwire) -> None:
    assert goalwire('fleet send drive order=1').code == 2
    assert goalwire('fleet send drive order=1 -r betta').code == 3
    assert "did you mean '/albert/drive'" in goalwire('fleet send drife order=1 -r *').err
    assert goalwire('fleet send drive order=x -r *').code == 4


def test_ctrl_c_cancels_all_goals_and_waits_for_their_ends(
    goalwire: Goalwire, begin: Begin, robots: Program, tmp_path: Path
) -> None:
    words = ('fleet', 'send', 'drive', 'order=0', '-r', 'al*')
    with begin(*words, program='goalwire', XDG_STATE_HOME=str(tmp_path)) as command:
        robots.expect('^drives$')
        robots.expect('^drives$')
        command.send_signal(signal.SIGINT)
        command.expect('^albert +CANCELED')
        command.expect('^alpha +CANCELED')
        assert command.wait() == 130
    robots.expect('^stopped$')
    robots.expect('^stopped$')
