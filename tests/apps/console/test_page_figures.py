"""The page is right about a robot: about rates from the first on, ages if the clock jumps, its model."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import confirm, row, until, view
from helpers.processes import Program

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

JUMPING = """
import signal, time
true_time, true_time_ns, hours = time.time, time.time_ns, 0
time.time = lambda: true_time() + 3600 * hours
time.time_ns = lambda: true_time_ns() + 3_600_000_000_000 * hours
def jump(number, _frame):
    global hours
    hours += 1 if number == signal.SIGUSR1 else -1
    print('jumped', hours, flush=True)
signal.signal(signal.SIGUSR1, jump)
signal.signal(signal.SIGUSR2, jump)
"""
"""The wall clock of a process that runs this goes on or back by an hour at a signal."""
FORWARDS, BACKWARDS = signal.SIGUSR1, signal.SIGUSR2


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


@pytest.fixture(scope='module')
def world() -> Iterator[tuple[Stage, Program, str]]:
    """A robot, and a console whose clock can jump; its address."""
    pytest.importorskip('nicegui')
    stage = Stage('rmw_zenoh_cpp')
    stage.robot()
    console, url = stage.console(first=JUMPING, anew=True)
    yield stage, console, url
    stage.close()


def test_a_rate_is_right_whenever_it_is_shown(world: tuple[Stage, Program, str], open_page: OpenPage) -> None:
    stage, _, url = world
    page = open_page(f'{url}?view=logs')
    stage.program(PROGRAMS / 'steady.py').expect('ready')
    page.evaluate("""() => {
      window.shown = {};
      new MutationObserver(() => {
        for (const name of ['steady', 'slow', 'latched']) {
          const cell = document.querySelector(`tr[data-key="/${name}"] td:last-child`);
          if (cell && cell.textContent.trim()) (window.shown[name] ??= []).push(cell.textContent);
        }
      }).observe(document.body, { subtree: true, childList: true, characterData: true }); }""")
    view(page, 'topics')
    row(page, '/steady')
    count = page.locator('text=/^(3[5-9]|[4-9]\\d|\\d{3,}) messages/')  # of ten a second
    count.wait_for()
    until(page, '() => window.shown.steady && window.shown.slow')
    picture(page, 'rates')
    shown = page.evaluate('() => window.shown')
    assert all(9 <= float(each.removesuffix(' Hz')) <= 11 for each in shown['steady']), shown['steady']
    assert all(0.8 <= float(each.removesuffix(' Hz')) <= 1.2 for each in shown['slow']), shown['slow']
    assert 'latched' not in shown, 'nobody knows its rate'


LATCHED = """
import asyncio, sys
import goalwire
from std_msgs.msg import String

async def main():
    async with goalwire.Node('vandal') as node:
        qos = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        node.publisher(String, 'robot_description', qos=qos).publish(data='<robot name="broken"><link')
        print('ready', flush=True)
        await asyncio.Event().wait()

asyncio.run(main())
"""


def test_a_description_that_cannot_be_read_leaves_the_robot_where_it_is(
    world: tuple[Stage, Program, str], open_page: OpenPage
) -> None:
    stage, _, url = world
    page = open_page(f'{url}?view=robot')
    until(page, '() => window.goalwireScene?.poses?.().left_arm !== undefined')
    page.wait_for_selector('[data-joint=head_joint]')
    stage.program(LATCHED).expect('ready')
    page.wait_for_selector(
        '[data-robot-problem]:has-text("the one before is shown"):has-text("cannot be read")'
    )
    pose = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(pose) => Math.abs(goalwireScene.poses().left_arm[4] - pose[4]) > 0.1', pose)
    assert page.locator('[data-joint=head_joint]').is_visible()
    picture(page, 'description-broken')


def test_ages_and_rates_are_right_when_the_clock_jumps(
    world: tuple[Stage, Program, str], open_page: OpenPage
) -> None:
    stage, console, url = world

    def jump(way: signal.Signals) -> None:
        console.send_signal(way)
        console.expect('jumped')

    # A goal lasts as long as it lasts, and the table of topics goes on.
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.fill('[data-field=order]', '93')
    page.click('[data-send-goal]')
    confirm(page)
    page.wait_for_selector('[data-goal] [data-status]:has-text("executing")')
    for way in (BACKWARDS, FORWARDS):
        jump(way)
        text = page.inner_text('[data-goal]')
        until(page, "(old) => document.querySelector('[data-goal]').innerText !== old", text)
        lasted = re.search(r'\d\d:\d\d:\d\d · (\S+) (µs|ms|s) ·', page.inner_text('[data-goal]'))
        assert lasted is not None
        assert 0 < float(lasted[1]) * {'µs': 1e-6, 'ms': 1e-3, 's': 1.0}[lasted[2]] < 600
    page.click('[data-cancel]')
    page.wait_for_selector('[data-goal] [data-status]:has-text("canceled")')
    view(page, 'topics')
    jump(BACKWARDS)
    until(page, '() => /Hz/.test(document.querySelector(\'tr[data-key="/load"]\')?.textContent)')

    # A robot that is silent stays so, and its news have the age that they have.
    view(page, 'robot')
    stage.command('ros2 service call /hush std_srvs/srv/SetBool "{data: true}"')
    page.wait_for_selector('[data-fresh]:has-text("no news for ")')
    page.wait_for_selector('[data-battery]:has-text(" s ago")')
    news = page.locator('[data-fresh]')
    for way in (FORWARDS, BACKWARDS):
        jump(way)
        before = news.inner_text()
        until(page, "(old) => document.querySelector('[data-fresh]').textContent !== old", before)
        assert seconds_in(before) <= seconds_in(news.inner_text()) < 600
        assert 0 <= seconds_in(page.inner_text('[data-battery]').partition(',')[2]) < 600


def seconds_in(text: str) -> int:
    """Return the age that a text tells, as in 'no news for 7 s'."""
    found = re.search(r'(-?\d+) s', text)
    assert found is not None, text
    return int(found[1])
