"""A session that looks at some robots of a fleet: what its router tells it, and whom it reaches."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from helpers.patience import PATIENCE, wait_for
from helpers.zenoh_sides import Ours, Side, Theirs, address

from goalwire.rules.names.robots import view_of
from goalwire.transport.zenoh.native_wire import NativeWire
from goalwire.transport.zenoh.ros_keys import robot_keys
from goalwire.zenoh.io.settings import Settings
from goalwire.zenoh.protocol.link_messages import Role


def token(robot: str, number: int) -> str:
    """Return the token of a publisher in a robot's inner namespace."""
    return (
        f'@ros2_lv/0/ab/0/{number}/MP/%/%{robot}%arm/driver/%{robot}%state/t::dds_::T_/RIHS01_00/::,:,:,:,,'
    )


@pytest.fixture(params=[Ours, Theirs], ids=lambda make: make.make)
def world(request: pytest.FixtureRequest) -> Iterator[tuple[str, Side]]:
    """A router of either make, and a session at it that has the tokens of three robots."""
    with ExitStack() as stack:
        where = address()
        router = request.param('router', listen=(where,))
        stack.callback(router.close)
        robots = Ours('client', connect=(where,))
        stack.callback(robots.close)
        for number, robot in enumerate(('alpha', 'albert', 'beta')):
            robots.token(token(robot, number))
            robots.serve(f'0/{robot}/switch', b'done')
        await_robots(where, 3)
        yield where, robots


def await_robots(where: str, number: int) -> None:
    """Wait until the router knows the tokens and the servers of so many robots."""
    with ExitStack() as stack:
        [link] = open_wire(where, '*', stack).session.protocol.links
        told = link.peer
        wait_for(lambda: len(set(told.tokens.values())) == number, 'the tokens of the robots')
        wait_for(lambda: sum(1 for _ in told.queryables.meeting('0/*/switch')) == number, 'their servers')


def open_wire(where: str, pattern: str, stack: ExitStack) -> NativeWire:
    settings = Settings(role=Role.CLIENT, connect=(where,), listen=())
    wire = NativeWire(settings, scope=robot_keys(0, view_of(pattern)))
    stack.callback(wire.close)
    return wire


def ask(wire: NativeWire, key: str, stack: ExitStack) -> list[bytes]:
    """Return the answers to a query."""
    querier = wire.declare_querier(key)
    stack.callback(querier.undeclare)
    answers: list[bytes] = []
    ended = threading.Event()
    querier.ask(b'', b'', lambda reply: answers.append(bytes(reply.payload or b'')), ended.set, None)
    assert ended.wait(PATIENCE), 'the query did not end'
    return answers


@pytest.mark.parametrize(('pattern', 'seen'), [('alpha', 1), ('al*', 2), ('*', 3), ('be', 0)])
def test_the_router_tells_of_the_robots_in_view_alone(
    world: tuple[str, Side], pattern: str, seen: int
) -> None:
    with ExitStack() as stack:
        wire = open_wire(world[0], pattern, stack)
        [link] = wire.session.protocol.links
        wait_for(lambda: link.peer.knows_all, 'the answers of the router')
        assert len(set(link.peer.tokens.values())) == seen
        assert sum(1 for _ in link.peer.queryables.meeting('0/*/switch')) == seen


def test_a_name_outside_of_the_view_is_reached_all_the_same(world: tuple[str, Side]) -> None:
    where, robots = world
    with ExitStack() as stack:
        wire = open_wire(where, 'alpha', stack)
        heard = robots.subscribe('0/tf/T')
        assert [ask(wire, f'0/{robot}/switch', stack) for robot in ('beta', 'alpha')] == [
            [b'done'],
            [b'done'],
        ]
        wire.declare_publisher('0/tf/T', reliable=True, waits=True).put(b'moved', attachment=b'')
        heard.wait(1)
