"""The page where something is lost beneath it or beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import until
from helpers.processes import Program

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

ROUTER = "import sys; from goalwire.cli.main import run_command; sys.exit(run_command('ros2', ['router']))"


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def router(stage: Stage) -> Program:
    """Start the router at which the stage's programs meet."""
    started = stage.program(ROUTER)
    started.expect('^router [0-9a-f]+ listens')
    return started


def test_a_router_that_is_killed_is_missed_until_it_is_back(stage: Stage, open_page: OpenPage) -> None:
    """Clients reach each other through the router alone."""
    stage.env['GOALWIRE_ROUTER'] = 'off'
    first = router(stage)
    routers = stage.env
    stage.env = routers | {'ZENOH_CONFIG_OVERRIDE': 'mode="client"'}
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.wait_for_selector('[data-fresh]:text-is("live")')
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')
    page.wait_for_selector('[data-estop]')

    first.kill()
    page.wait_for_selector('[data-nodes]:has-text("nobody else on the wire")')
    page.wait_for_selector('[data-gone]:has-text("It has gone")')
    page.wait_for_selector('.gw-stale')
    page.wait_for_selector('[data-battery]', state='hidden')
    page.wait_for_selector('[data-estop]', state='hidden')
    picture(page, 'router-gone')

    stage.env = routers
    router(stage)
    page.wait_for_selector('[data-fresh]:text-is("live")')
    page.wait_for_selector('.gw-stale', state='detached')
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')
    pose = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(pose) => Math.abs(goalwireScene.poses().left_arm[4] - pose[4]) > 0.1', pose)
    page.click('[data-estop]')
    robot.expect('stopped')


def test_peers_lose_nothing_with_the_router_but_those_who_come(stage: Stage, open_page: OpenPage) -> None:
    """Peers are joined by links of their own."""
    stage.env |= {'GOALWIRE_ROUTER': 'off'}
    first = router(stage)
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.wait_for_selector('[data-fresh]:text-is("live")')
    first.kill()
    first.wait()
    stage.program(PROGRAMS / 'introspected.py').expect('ready')
    pose = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(pose) => Math.abs(goalwireScene.poses().left_arm[4] - pose[4]) > 0.1', pose)
    page.wait_for_selector('[data-fresh]:text-is("live")')
    router(stage)
    page.click('[data-view=services]')
    page.wait_for_selector('tr[data-key="/add"]')
