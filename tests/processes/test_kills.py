"""kill -9 of any one process: the others work on; whoever comes next finds them, before any lease ends."""

from __future__ import annotations

import re

import pytest
from helpers.processes import Program
from helpers.programs import Start

pytestmark = pytest.mark.slow

JOINING = ['on', 'off']
"""How a newcomer joins: offering a rendezvous itself, or, as rmw_zenoh does, only looking for one."""


class Robot:
    """A node that holds the rendezvous, and two pairs of a server and a client that talk all the time."""

    def __init__(self, start: Start) -> None:
        self.programs = {'rendezvous': start('idle')}
        self.programs['rendezvous'].expect('ready')  # the first of all, so the port is its own
        for pair in ('left', 'right'):
            self.programs[f'{pair} server'] = start('add_server', pair)
            self.programs[f'{pair} client'] = start('steady_client', pair)
        for pair in ('left', 'right'):
            self.programs[f'{pair} client'].expect('answer 2$')

    def kill(self, name: str) -> None:
        """kill -9, and wait until the process is gone."""
        self.programs[name].kill()
        self.programs[name].wait()

    def works_on(self, pair: str) -> None:
        """Insist on the answer to a call made later than any that has been answered so far."""
        client = self.programs[f'{pair} client']
        last = int(re.findall(r'answer (\d+)', client.output)[-1])
        while int(client.expect(r'answer (\d+)').group(1)) < last + 3:
            pass


def prepared_newcomer(start: Start, joining: str) -> Program:
    """Return a process that has imported everything and waits to be told to join."""
    newcomer = start('newcomer', GOALWIRE_ROUTER=joining)
    newcomer.expect('ready')
    return newcomer


def assert_joins(newcomer: Program, service: str) -> None:
    """See it join, and be answered: no lease of Zenoh's, 60 s, is over by then."""
    newcomer.write_line(service)
    newcomer.expect('answered after')
    newcomer.succeed()


@pytest.mark.parametrize(
    ('victim', 'joining'),
    [
        ('rendezvous', 'on'),
        ('rendezvous', 'off'),
        ('right server', 'on'),
        ('right client', 'off'),
        # How a newcomer joins matters if the rendezvous is lost; of others, one each is enough.
        pytest.param('right server', 'off', marks=pytest.mark.long),
        pytest.param('right client', 'on', marks=pytest.mark.long),
    ],
)
def test_after_a_kill_the_others_work_on_and_a_newcomer_finds_them(
    start: Start, victim: str, joining: str
) -> None:
    newcomer = prepared_newcomer(start, joining)
    robot = Robot(start)
    robot.kill(victim)
    assert_joins(newcomer, 'left')
    robot.works_on('left')
    if victim == 'rendezvous':
        robot.works_on('right')


@pytest.mark.parametrize('joining', JOINING)
def test_the_rendezvous_survives_one_holder_after_the_other(start: Start, joining: str) -> None:
    holders = [start('idle') for _ in range(3)]
    for holder in holders:
        holder.expect('ready')
    server = start('add_server')
    server.expect('ready')
    for holder in holders:
        newcomer = prepared_newcomer(start, joining)
        holder.kill()
        holder.wait()
        assert_joins(newcomer, 'add')


def test_a_client_gets_answers_again_once_its_killed_server_is_back(start: Start) -> None:
    robot = Robot(start)
    robot.kill('right server')
    start('add_server', 'right').expect('ready')
    robot.works_on('right')
