"""Managed nodes in processes of their own, and a manager in another that brings them up and down."""

from __future__ import annotations

import signal

from helpers.programs import Start


def test_a_manager_brings_nodes_up_in_order_and_down_in_the_other(start: Start) -> None:
    laser, planner = start('managed_node', 'laser', 'on_configure'), start('managed_node', 'planner')
    manager = start('lifecycle_manager', 'laser', 'planner')
    assert manager.succeed().splitlines() == [
        'laser failed and is unconfigured',
        'laser became inactive, and is inactive',
        'planner became inactive, and is inactive',
        'laser became active, and is active',
        'planner became active, and is active',
        'planner became inactive, and is inactive',
        'laser became inactive, and is inactive',
        'planner became unconfigured, and is unconfigured',
        'laser became unconfigured, and is unconfigured',
        'planner became finalized, and is finalized',
        'laser became finalized, and is finalized',
    ]
    for callback in ('configure from un', 'error from un', 'configure from un', 'activate from inactive'):
        laser.expect(f'^on_{callback}')
    for node in (laser, planner):
        node.expect('^on_shutdown from unconfigured$')
        node.send_signal(signal.SIGINT)
        node.expect('^left$')
        assert node.wait() == 0
    assert '[laser]: Error raised in on_configure(): the laser is not plugged in' in laser.output
