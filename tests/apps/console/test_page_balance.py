"""A robot that has fallen, in a real browser: the page says so, puts it up, and pushes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def confirm(page: Any, title: str) -> None:
    page.wait_for_selector(f'.q-dialog:has-text("{title}")')
    page.click('.q-dialog [data-send]')
    page.wait_for_selector('.q-dialog', state='detached')


def test_a_fallen_robot_is_put_up_and_pushed(stage: Stage, open_page: OpenPage) -> None:
    stage.program(PROGRAMS / 'tumbler.py').expect('ready')
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.wait_for_selector('[data-balance-state]:has-text("fallen")')
    picture(page, 'fallen')
    page.click('[data-get-up]')
    confirm(page, 'Put the robot back on its feet?')
    page.wait_for_selector('.q-notification:has-text("it stands again")')
    page.wait_for_selector('[data-balance-state]:has-text("on its feet")')
    page.wait_for_selector('[data-get-up]', state='hidden')

    # It faces along y of the world, so a push ahead is one along y.
    page.click('[data-push=ahead]')
    confirm(page, 'Push the robot? It may fall.')
    page.wait_for_selector('.q-notification:has-text("pushed by 0, 60 N")')
    page.click('[data-push=left]')
    confirm(page, 'Push the robot? It may fall.')
    page.wait_for_selector('.q-notification:has-text("pushed by -60, 0 N")')


def test_a_console_that_may_not_send_shows_how_it_stands_alone(stage: Stage, open_page: OpenPage) -> None:
    stage.program(PROGRAMS / 'tumbler.py').expect('ready')
    _, url = stage.console('--read-only')
    page = open_page(f'{url}?view=robot')
    page.wait_for_selector('[data-balance-state]:has-text("fallen")')
    assert page.locator('[data-get-up]:visible').count() == 0
    assert page.locator('[data-push=ahead]:visible').count() == 0
