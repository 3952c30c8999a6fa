"""A recording in a real browser: the timeline is dragged, played and stepped through; nothing can be sent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from helpers.console import Stage, picture
from helpers.page import row, until
from helpers.recorded_robot import SECONDS, write_recorded_robot

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

_X = '() => window.goalwireScene?.poses?.().base_link?.[0]'


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(write_recorded_robot(tmp_path_factory.mktemp('bag') / 'trip'))


@pytest.fixture(scope='module')
def world(bag: str) -> Iterator[tuple[Stage, str]]:
    """A console that shows the recording, and its address: each page has a timeline of its own."""
    pytest.importorskip('nicegui')
    stage = Stage('rmw_zenoh_cpp')
    yield stage, stage.console('--bag', bag)[1]
    stage.close()


@pytest.fixture
def url(world: tuple[Stage, str]) -> str:
    return world[1]


def _at(page: Any, seconds: float) -> None:
    """Wait until the page says that it stands there, to a tenth of a second."""
    until(page, f"() => document.querySelector('[data-time]').textContent.startsWith('{seconds:.1f}')")


def _drag(page: Any, *parts: float) -> None:
    box = page.locator('[data-timeline] canvas').bounding_box()
    left, width = box['x'] + 12, box['width'] - 24
    page.mouse.move(left + width * parts[0], box['y'] + 12)
    page.mouse.down()
    for part in parts[1:]:
        page.mouse.move(left + width * part, box['y'] + 12, steps=5)
    page.mouse.up()


def test_the_robot_follows_the_timeline(open_page: OpenPage, url: str) -> None:
    page = open_page(url)
    page.wait_for_selector('[data-recording]:has-text("not live")')
    until(page, f'() => Math.abs(({_X})() - 1) < 0.01')

    # The mouse: on to half of it, and back to a quarter. What was latched at the start is there in both.
    _drag(page, 0.1, 0.5)
    until(page, f'() => Math.abs(({_X})() - 2.5) < 0.05')
    page.wait_for_selector('[data-log] :text("second 29 has come")')
    _drag(page, 0.5, 0.25)
    until(page, f'() => Math.abs(({_X})() - 1.75) < 0.05')
    page.wait_for_selector('[data-log] :text("second 14 has come")')
    assert page.locator('[data-log] :text("second 29 has come")').count() == 0
    picture(page, 'recording')

    # Keys: to the end, back by a tenth and by five seconds, to the start.
    page.keyboard.press('End')
    _at(page, SECONDS)
    page.keyboard.press('ArrowLeft')
    _at(page, SECONDS - 0.1)
    page.keyboard.press('Shift+ArrowLeft')
    _at(page, SECONDS - 5.1)
    page.keyboard.press('Home')
    _at(page, 0.0)
    until(page, f'() => Math.abs(({_X})() - 1) < 0.01')

    # It plays, faster when told, and pauses.
    page.keyboard.press('+')
    page.keyboard.press('+')
    page.keyboard.press('Space')
    until(page, f'() => ({_X})() > 1.5')
    page.keyboard.press('Space')
    page.wait_for_selector('[data-play] :text("play_arrow")')

    # While nothing moves, no pictures are drawn.
    for rests in ('!goalwireScene.moving && !goalwireScene.request', '!goalwireLanes.request'):
        until(page, f'() => {rests}')


def test_goals_plots_and_messages_of_the_whole_time(open_page: OpenPage, url: str) -> None:
    page = open_page(url)
    until(page, '() => window.goalwireLanes?.hits?.length === 2')
    statuses = page.evaluate('() => goalwireLanes.hits.map(hit => hit[4].status)')
    assert sorted(statuses) == ['ABORTED', 'SUCCEEDED']
    row(page, '/load')
    page.click('.gw-plot-button')
    page.wait_for_selector('[data-series]:has-text("/load data")')
    until(
        page,
        """() => {
            const id = Number(document.querySelector('[data-plot]').id.slice(1))
            const lines = getElement(id)?.chart?.getOption()?.series ?? []
            return Math.max(...lines.flatMap(line => line.data.map(point => point[1]))) === 90
        }""",
    )
    _drag(page, 0.2, 25 / SECONDS + 0.0005)
    page.wait_for_selector('[data-message-time]:has-text("at 25.0")')


def test_nothing_can_be_sent_while_a_recording_is_shown(
    world: tuple[Stage, str], open_page: OpenPage
) -> None:
    """The page has no control for it, and the console has no node: the robot beside it sees nobody."""
    stage, url = world
    stage.robot()
    page = open_page(url)
    page.wait_for_selector('[data-timeline] canvas')
    page.keyboard.press('Control+Shift+Space')
    page.keyboard.press('Pause')
    for control in ('[data-estop]', '[data-send-goal]', '[data-call]', '[data-publish]', '[data-view]'):
        assert page.locator(control).count() == 0, control
    assert 'goalwire_console' not in stage.command('ros2 node list')


def test_a_page_has_animations_unless_its_user_wants_none(open_page: OpenPage, url: str) -> None:
    page = open_page(url)
    glow = page.wait_for_selector('[data-play] .q-focus-helper', state='attached')
    lasts = 'glow => getComputedStyle(glow).transitionDuration'
    page.emulate_media(reduced_motion='no-preference')
    assert glow.evaluate(lasts) == '0.3s, 0.4s'
    page.emulate_media(reduced_motion='reduce')
    assert glow.evaluate(lasts) == '0s'


def test_a_console_that_has_gone_is_told_and_the_page_goes_on_with_the_next_one(
    stage: Stage, open_page: OpenPage, bag: str
) -> None:
    console, url = stage.console('--bag', bag)
    page = open_page(url)
    page.wait_for_selector('[data-timeline] canvas')
    console.kill()
    page.wait_for_selector('[data-lost]:has-text("No connection to the console")')
    assert 'STOP' not in page.inner_text('[data-lost]')
    assert page.evaluate("() => document.getElementById('app').inert")
    stage.console('--bag', bag, '--port', url.rstrip('/').rpartition(':')[2])
    page.wait_for_selector('[data-lost]', state='hidden')
    until(page, f'() => Math.abs(({_X})() - 1) < 0.01')
