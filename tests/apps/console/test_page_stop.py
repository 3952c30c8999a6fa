"""STOP in a real browser: at every width, with anything open, with two robots, and with nobody to answer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import pytest
from helpers.console import DATA, PROGRAMS, Stage, picture
from helpers.page import confirm, new_context, row, until, view
from helpers.processes import Program

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

WIDTHS = ((390, 800), (600, 800), (768, 900), (1440, 800))
SOME_WIDTHS = [pytest.param(*each, marks=() if each[0] == 390 else pytest.mark.long) for each in WIDTHS]
"""The narrowest, where all lies closest, in each run, the others in the long one."""
ASKED = r'robot: asked True'

ON_TOP = """selector => {
  const one = document.querySelector(selector), box = one.getBoundingClientRect();
  const spots = [[0.5, 0.5], [0.05, 0.5], [0.95, 0.5], [0.5, 0.1], [0.5, 0.9]].map(([x, y]) =>
    document.elementFromPoint(box.left + x * box.width, box.top + y * box.height));
  return box.left >= 0 && box.top >= 0 && box.right <= innerWidth && box.bottom <= innerHeight
    && box.height >= 40 && spots.every(each => one.contains(each)); }"""
"""Whether an element lies in the viewport, and nothing lies on it."""


NAME_IS_WHOLE = """() => {
  const name = document.querySelector('.gw-top .gw-robot .q-field__native > span');
  return name.textContent === '/alice (gone)' && name.scrollWidth <= name.clientWidth
    && name.scrollHeight <= name.clientHeight; }"""
"""Whether no letter of the selected robot's name is cut off."""

STANDS_STILL = "() => document.getAnimations().every(each => each.playState !== 'running')"


class World(NamedTuple):
    """Two robots, a console, and a page."""

    stage: Stage
    alice: Program
    bob: Program
    console: Program
    url: str
    page: Any


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver and the world live until the module's end; robots and console are processes."""


def robot(stage: Stage, name: str, x: float) -> Program:
    """Start a robot that can be stopped."""
    return stage.program(PROGRAMS / 'stoppable.py', str(DATA / 'robot.urdf'), name, str(x))


@contextmanager
def world_of(window: Any) -> Iterator[World]:
    """Two robots, a console and a page."""
    stage = Stage('rmw_zenoh_cpp')
    try:
        alice, bob = robot(stage, 'alice', 1.0), robot(stage, 'bob', 3.0)
        alice.expect('ready')
        bob.expect('ready')
        console, url = stage.console()
        errors: list[str] = []
        page = window.new_page()
        page.set_viewport_size({'width': 1440, 'height': 800})
        page.on('pageerror', lambda error: errors.append(str(error)))
        page.goto(f'{url}?view=services')
        until(page, "() => document.querySelectorAll('[data-estop-all]').length === 1")
        yield World(stage, alice, bob, console, url, page)
        page.close()
    finally:
        stage.close()
    assert errors == [], 'errors in the page'


@pytest.fixture(scope='module')
def world(window: Any) -> Iterator[World]:
    """The world that is shared by the tests that leave both robots released, and alive."""
    with world_of(window) as made:
        yield made


@pytest.fixture
def own_world(window: Any) -> Iterator[World]:
    """A world of its own for a test that kills something."""
    with world_of(window) as made:
        yield made


@pytest.fixture
def page(world: World) -> Any:
    """The page that they share, at its first view and width, with alice selected and nothing open.

    That view has no scene: to draw one costs more than all else that most of these tests do.
    """
    page = world.page
    page.set_viewport_size({'width': 1440, 'height': 800})
    page.keyboard.press('Escape')
    page.keyboard.press('Escape')
    select(page, '/alice')
    view(page, 'services')
    return page


def select(page: Any, name: str) -> None:
    """Select a robot."""
    if page.inner_text('.gw-stop-robot') != name:
        open_menu(page)
        page.click(f'.q-menu .q-item:has-text("{name}")')
        page.wait_for_selector(f'.gw-stop-robot:text-is("{name}")')
        page.wait_for_selector('.q-menu', state='detached')


def open_menu(page: Any) -> None:
    """Open the list of robots."""
    page.locator('.q-select', has=page.locator('[data-robot]')).click()
    page.wait_for_selector('.q-menu .q-item')


def open_call(page: Any) -> None:
    """Open the question before a call."""
    view(page, 'services')
    row(page, '/bob/emergency_stop')
    page.click('[data-call]')
    page.wait_for_selector('.q-dialog [data-send]')


def open_floor(page: Any) -> None:
    """Open the question before a goal, by a click on the floor."""
    view(page, 'robot')
    until(page, '() => window.goalwireScene?.poses?.().base_link !== undefined')
    box = page.locator('.gw-scene canvas').bounding_box()
    page.mouse.click(box['x'] + box['width'] / 2, box['y'] + box['height'] * 0.8)
    page.wait_for_selector('.q-dialog [data-send]')


def open_release(page: Any) -> None:
    """Open the question before a release."""
    page.click('[data-release]')
    page.wait_for_selector('.q-dialog [data-send]')


def test_a_killed_server_takes_stop_away_and_no_other_robot_takes_its_place(own_world: World) -> None:
    world, page = own_world, own_world.page
    view(page, 'robot')
    select(page, '/alice')
    world.alice.kill()
    page.wait_for_selector('[data-no-estop]:has-text("cannot be stopped from here")')
    assert page.locator('[data-estop]').count() == 0
    page.wait_for_selector('[data-banner=unknown]:has-text("not known")')
    for width, height in WIDTHS:
        page.set_viewport_size({'width': width, 'height': height})
        until(page, ON_TOP, '[data-no-estop]')
        until(page, NAME_IS_WHOLE)
        picture(page, f'stop-killed-{width}')
    page.wait_for_selector('[data-gone]:has-text("It has gone")')
    page.evaluate("""() => {
      window.told = [];
      const read = report => report?.lines.map(line => `${line.service} ${line.text}`) ?? [];
      goalwireStop.$watch('report', report => window.told.push(...read(report)), { deep: true }); }""")
    page.keyboard.press('Pause')
    page.wait_for_selector('[data-stop-report=failed]:has-text("/alice/emergency_stop")')
    until(page, "() => window.told.some(text => text.startsWith('/alice/emergency_stop no server of'))")
    picture(page, 'stop-killed-pressed')
    page.click('[data-dismiss]')

    # The console's own client makes no row in the list of services; that of others is one without a server.
    view(page, 'services')
    page.wait_for_selector('tr[data-key="/bob/emergency_stop"]')
    assert page.locator('tr[data-key="/alice/emergency_stop"]').count() == 0

    page.click('[data-estop-all]')
    world.bob.expect(ASKED)
    page.wait_for_selector(
        '[data-stop-report=failed] .gw-report-line:has-text("/bob/emergency_stop stopped")'
    )
    page.click('[data-dismiss]')
    again = robot(world.stage, 'alice', 1.0)
    again.expect('ready')
    page.wait_for_selector('[data-banner=unknown]', state='detached')
    page.click('[data-estop]')
    again.expect(ASKED)
    page.wait_for_selector('[data-banner=stopped]')


def test_a_console_that_does_not_answer_stops_nothing_and_says_so(own_world: World) -> None:
    page = own_world.page
    open_floor(page)
    own_world.console.kill()
    page.wait_for_selector('[data-lost]')
    for width, height in WIDTHS:
        page.set_viewport_size({'width': width, 'height': height})
        for above in ('[data-estop]', '[data-estop-all]', '[data-lost]'):
            until(page, ON_TOP, above)
        picture(page, f'stop-lost-{width}')
    page.keyboard.press('Pause')
    page.wait_for_selector('[data-stop-report=failed]:has-text("the console cannot be reached")')
    picture(page, 'stop-console-gone')


@pytest.mark.parametrize(('width', 'height'), SOME_WIDTHS)
def test_one_click_stops_whatever_is_open(world: World, page: Any, width: int, height: int) -> None:
    page.set_viewport_size({'width': width, 'height': height})
    page.click('[data-estop]')
    world.alice.expect(ASKED)
    page.wait_for_selector('[data-banner=stopped]')
    for opened, what in (
        (open_floor, '.q-dialog'),
        (open_menu, '.q-menu'),
        (open_release, '.q-dialog'),
        (open_call, '.q-dialog'),
    ):
        opened(page)
        until(page, ON_TOP, '[data-estop]')
        until(page, ON_TOP, '[data-estop-all]')
        until(page, STANDS_STILL)
        picture(page, f'stop-{width}-{opened.__name__}')
        x, y = page.evaluate(
            """() => { const box = document.querySelector('[data-estop]').getBoundingClientRect();
            return [box.left + box.width / 2, box.top + box.height / 2]; }"""
        )
        page.mouse.click(x, y)
        world.alice.expect(ASKED)
        page.wait_for_selector('[data-stop-report=stopped]')
        assert page.locator('.q-dialog').count() == (what == '.q-dialog'), 'dialogs stay open'
        page.click('[data-dismiss]')
        page.keyboard.press('Escape')
        page.wait_for_selector(what, state='detached')
    overflow = 'document.documentElement.scrollWidth - innerWidth'
    assert page.evaluate(overflow) <= 0
    page.click('[data-release]')
    confirm(page)
    world.alice.expect('robot: asked False')
    page.wait_for_selector('[data-banner]', state='detached')


def test_a_finger_stops_although_a_menu_is_open(world: World, page: Any, chromium: Any) -> None:
    """A menu takes the touch that closes it."""
    context = new_context(chromium, 390, 800, has_touch=True, is_mobile=True)
    phone = context.new_page()
    phone.goto(f'{world.url}?view=robot&robot=/alice')
    phone.wait_for_selector('[data-estop]')
    phone.wait_for_selector('[data-way]:visible')
    # A menu that opens while the page loads is not placed.
    chosen = phone.locator('.q-select', has=phone.locator('[data-robot]'))
    while not phone.locator('.q-item').first.is_visible():
        chosen.tap()
        phone.wait_for_timeout(500)
    phone.locator('[data-estop]').tap(force=True)
    world.alice.expect(ASKED)
    phone.wait_for_selector('[data-banner=stopped]')
    picture(phone, 'stop-phone')
    context.close()
    release(page)


def release(page: Any) -> None:
    """Release the selected robot."""
    page.click('[data-release]')
    confirm(page)
    page.wait_for_selector('[data-banner]', state='detached')


@pytest.mark.parametrize('key', ['Pause', 'Control+Shift+Space'])
def test_a_key_stops_while_a_field_has_the_focus(world: World, page: Any, key: str) -> None:
    view(page, 'services')
    page.fill('[data-filter]', 'stop')
    page.focus('[data-filter]')
    page.keyboard.press(key)
    world.alice.expect(ASKED)
    page.wait_for_selector('[data-banner=stopped]')
    assert page.input_value('[data-filter]') == 'stop', 'it types nothing'
    open_release(page)
    page.keyboard.press(key)
    world.alice.expect(ASKED)
    assert page.locator('.q-dialog').count() == 1
    confirm(page)
    page.wait_for_selector('[data-banner]', state='detached')


def set_parameter(world: World, node: str, name: str, value: str) -> None:
    """Set a parameter, as another program does."""
    world.stage.command(f'ros2 param set {node} {name} {value}')


def test_a_stop_that_nobody_confirms_fails_loudly_after_a_second(world: World, page: Any) -> None:
    set_parameter(world, '/alice/robot', 'deaf', 'true')
    page.evaluate("""() => {
      window.states = [];
      goalwireStop.$watch('report.state', state => window.states.push([state, performance.now()])); }""")
    page.click('[data-estop]')
    assert page.inner_text('[data-estop]').startswith('stopping …')
    page.wait_for_selector('[data-stop-report=failed]')
    text = page.inner_text('[data-stop-report]')
    for part in ('STOP FAILED', '/alice may still move', '/alice/emergency_stop', 'emergency switch'):
        assert part in text
    told = [each for each in page.evaluate('() => window.states') if each[0]]
    (first, began), (second, ended), *_ = told
    assert (first, second) == ('stopping', 'failed')
    assert 900 < ended - began < 5000
    world.alice.expect(ASKED)
    picture(page, 'stop-failed')
    set_parameter(world, '/alice/robot', 'deaf', 'false')
    page.wait_for_selector('[data-stop-report=failed]')  # it stays
    page.click('[data-dismiss]')
    page.wait_for_selector('[data-stop-report]', state='detached')


def test_a_robot_that_says_stopped_and_is_not_is_told(world: World, page: Any) -> None:
    set_parameter(world, '/alice/robot', 'lying', 'true')
    page.click('[data-estop]')
    page.wait_for_selector('[data-stop-report=failed]:has-text("the robot says that it is not stopped")')
    assert page.locator('[data-banner]').count() == 0
    set_parameter(world, '/alice/robot', 'lying', 'false')
    page.click('[data-dismiss]')


def test_the_banner_says_what_the_robot_says_and_release_asks_once(world: World, page: Any) -> None:
    world.stage.command('ros2 service call /alice/emergency_stop std_srvs/srv/SetBool "{data: true}"')
    page.wait_for_selector('[data-banner=stopped]:has-text("/alice is stopped")')
    page.wait_for_selector('[data-reason]:text-is("/operator called the service")')
    page.click('[data-release]')
    page.wait_for_selector('.q-dialog:has-text("Release /alice?"):has-text("/operator called the service")')
    assert page.locator('.q-dialog >> text=Do not ask again').is_hidden()
    page.click('.q-dialog >> text=Cancel')
    page.wait_for_selector('.q-dialog', state='detached')
    page.wait_for_selector('[data-banner=stopped]')
    release(page)
    world.stage.command('ros2 service call /alice/emergency_stop std_srvs/srv/SetBool "{data: true}"')
    open_release(page)  # it asks again
    confirm(page)
    page.wait_for_selector('[data-banner]', state='detached')


def test_everything_belongs_to_the_selected_robot(world: World, page: Any) -> None:
    view(page, 'robot')
    until(page, "() => document.querySelector('[data-battery]').textContent === 'battery 62 %'")
    until(page, '() => window.goalwireScene?.poses?.().base_link?.[0] === 1')
    select(page, '/bob')
    until(page, "() => document.querySelector('[data-battery]').textContent === 'battery 31 %'")
    until(page, '() => goalwireScene.poses().base_link?.[0] === 3')
    head = page.evaluate('() => goalwireScene.poses().head')
    until(page, '(head) => Math.abs(goalwireScene.poses().head[2] - head[2]) > 0.01', head)
    assert page.evaluate('() => location.search') == '?view=robot&robot=/bob'
    page.wait_for_selector('text=Click on the floor to send /bob there')
    open_floor(page)
    page.wait_for_selector('.q-dialog:has-text("Send /bob to"):has-text("/bob/go_to")')
    picture(page, 'stop-bob-floor')
    confirm(page)
    world.bob.expect('robot: goes to')
    page.click('[data-estop]:has-text("/bob")')
    world.bob.expect(ASKED)
    page.wait_for_selector('[data-banner=stopped]:has-text("/bob")')
    picture(page, 'stop-bob')
    select(page, '/alice')
    page.wait_for_selector('[data-banner]', state='detached')

    # All robots at once, and what each answered.
    page.click('[data-estop-all]')
    world.bob.expect(ASKED)
    world.alice.expect(ASKED)
    report = page.wait_for_selector('[data-stop-report=stopped]').inner_text()
    assert 'every robot is stopped' in report
    assert '/alice/emergency_stop stopped after' in report
    assert '/bob/emergency_stop stopped after' in report
    picture(page, 'stop-all')
    assert 'goes to' not in world.alice.output
    release(page)
    select(page, '/bob')
    release(page)
