"""The page in a real browser, on both wires: a robot is watched, sent, called, and stopped."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from helpers.console import PATIENCE_MS, Stage, picture
from helpers.patience import wait_for
from helpers.wires import DDS, require

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def until(page: Any, expression: str, argument: object = None) -> Any:
    """Wait until an expression of the page's is true, and return it."""
    return page.wait_for_function(expression, arg=argument, timeout=PATIENCE_MS, polling=50).json_value()


def clipboard(page: Any, beginning: str) -> str:
    """Wait until the text that was copied last begins like this, and return it."""
    read = partial(page.evaluate, '() => navigator.clipboard.readText()')
    wait_for(lambda: read().startswith(beginning), f'a copied text that begins with {beginning!r}')
    return str(read())


def view(page: Any, name: str) -> None:
    page.click(f'[data-view={name}]')
    page.wait_for_selector(f'[data-view={name}].chosen')


def row(page: Any, key: str) -> None:
    page.click(f'tr[data-key="{key}"]')


def confirm(page: Any) -> None:
    page.click('.q-dialog [data-send]')
    page.wait_for_selector('.q-dialog', state='detached')


@pytest.mark.parametrize('transport_name', ['rmw_zenoh_cpp', DDS])
def test_a_robot_is_watched_sent_and_stopped(stage: Stage, open_page: OpenPage, transport_name: str) -> None:
    require(transport_name)
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')

    # It moves: an arm's pose, and what is drawn.
    until(page, '() => window.goalwireScene?.poses?.().left_arm !== undefined')
    first = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(first) => Math.abs(goalwireScene.poses().left_arm[4] - first[4]) > 0.1', first)
    drawn = page.evaluate('() => goalwireScene.renderer.domElement.toDataURL()')
    until(page, '(drawn) => goalwireScene.renderer.domElement.toDataURL() !== drawn', drawn)
    until(page, "() => document.querySelector('[data-battery]').textContent === 'battery 62 %'")
    picture(page, f'robot-{transport_name}')

    # A click on the floor sends it there, after one question.
    page.wait_for_selector('[data-way]')
    until(page, '() => goalwireScene.goals !== undefined')
    x, y = page.evaluate('() => goalwireScene.screen_of(0.8, 0.4, 0)')
    page.mouse.click(x, y)
    page.wait_for_selector('.q-dialog [data-send]')
    until(page, "() => goalwireScene.goals.has('new')")
    picture(page, f'floor-{transport_name}')
    assert page.evaluate('() => goalwireScene.poses().base_link.slice(0, 2)') == [0, 0]
    confirm(page)
    until(
        page,
        '() => Math.hypot(goalwireScene.poses().base_link[0] - 0.8,'
        ' goalwireScene.poses().base_link[1] - 0.4) < 0.1',
    )

    # A goal by the form: feedback comes, and it is cancelled.
    view(page, 'actions')
    row(page, '/count')
    page.fill('[data-field=order]', '90')
    page.click('[data-send-goal]')
    confirm(page)
    page.wait_for_selector('[data-goal] [data-status]:has-text("executing")')
    until(page, "() => document.querySelectorAll('[data-feedback] .gw-leaf').length > 1")
    until(page, '() => window.goalwireLanes.hits?.some(hit => hit[4].ticks.length > 2)')
    picture(page, f'actions-{transport_name}')
    page.click('[data-cancel]')
    page.wait_for_selector('[data-goal] [data-status]:has-text("canceled")')

    # Stop never asks, and the goal under way is aborted with its result kept.
    row(page, '/go_to')
    page.fill('[data-field=x]', '-3')
    page.fill('[data-field=speed]', '0.1')
    page.click('[data-send-goal]')
    confirm(page)
    page.wait_for_selector('[data-goal] [data-status]:has-text("executing")')
    page.click('[data-estop]')
    robot.expect('stopped')
    page.wait_for_selector('[data-goal] [data-status]:has-text("aborted")')
    page.wait_for_selector('[data-result]:has-text("arrived")')


def test_services_are_called_and_parameters_set(stage: Stage, open_page: OpenPage) -> None:
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=services')
    row(page, '/lamp')
    page.click('[data-field=data]')
    page.click('[data-call]')
    assert '{data: true}' in page.inner_text('[data-confirm]')
    confirm(page)
    robot.expect('lamp True')
    page.wait_for_selector('[data-answer]:has-text("on <b>and bright</b>")')
    page.click('[data-toggle-yaml]')
    page.fill('[data-yaml]', 'data: maybe')
    page.click('[data-call]')
    page.wait_for_selector('.q-notification:has-text("give true or false")')
    page.fill('[data-yaml]', '{data: false}')
    page.click('[data-call]')
    confirm(page)
    robot.expect('lamp False')
    page.wait_for_selector('[data-answer]:has-text("off")')
    picture(page, 'services')

    view(page, 'parameters')
    row(page, '/robot')
    speed = '[data-parameter=speed]'
    page.wait_for_selector(speed)
    page.fill(speed, '7')
    page.click('[data-set=speed]')
    page.wait_for_selector('.q-notification:has-text("0 to 2")')
    page.fill(speed, '1.5')
    page.click('[data-set=speed]')
    confirm(page)
    page.wait_for_selector('.q-notification:has-text("speed is set")')
    until(page, "() => document.querySelector('[data-parameter=speed]')?.value === '1.5'")
    picture(page, 'parameters')


def test_topics_are_measured_plotted_and_saved(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=topics')
    row(page, '/load')
    page.click('.gw-plot-button')
    page.wait_for_selector('[data-series]:has-text("/load data")')
    chart = "getElement(document.querySelector('[data-plot]').id.slice(1)).chart"
    until(page, f'() => ({chart}.getOption().series[0]?.data ?? []).length > 20')
    until(page, '() => /Hz/.test(document.querySelector(\'tr[data-key="/load"]\').textContent)')
    row(page, '/joint_states')
    page.wait_for_selector('.gw-tree:has-text("left_joint")')
    picture(page, 'topics')
    page.click('[data-pause]')
    with page.expect_download() as saved:
        page.click('[data-csv]')
    saved.value.save_as(tmp_path / 'plot.csv')
    rows = list(csv.DictReader((tmp_path / 'plot.csv').read_text(encoding='utf-8').splitlines()))
    assert len(rows) > 20
    assert {each['series'] for each in rows} == {'/load data'}
    assert all(2.0 <= float(each['value']) <= 4.0 for each in rows)
    with page.expect_download() as saved:
        page.click('[data-png]')
    saved.value.save_as(tmp_path / 'plot.png')
    assert (tmp_path / 'plot.png').read_bytes().startswith(b'\x89PNG')

    row(page, '/camera')
    until(
        page, "() => [...document.querySelectorAll('.gw-picture img')].some(each => each.naturalWidth === 64)"
    )

    row(page, '/texts')
    page.click('[data-open-publish]')
    page.fill('[data-field=data]', 'hello')
    page.click('[data-publish]')
    confirm(page)
    page.wait_for_selector('.gw-tree:has-text("hello")')


def test_what_peers_write_stays_text_and_mismatches_are_red(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=graph')
    page.wait_for_selector('[data-problems] tr.bad:has-text("/quarrel")')
    page.wait_for_selector('tr.bad:has-text("std_msgs/msg/Float64")')
    picture(page, 'graph')
    view(page, 'logs')
    page.wait_for_selector('td:has-text("<script>window.hacked = 1</script>")')
    picture(page, 'logs')
    view(page, 'topics')
    row(page, '/texts')
    page.wait_for_selector('.gw-tree:has-text("javascript:window.hacked=1")')
    view(page, 'statistics')
    page.wait_for_selector('td:has-text("/rosout")')
    assert page.evaluate('() => window.hacked') is None


def test_a_closed_page_cancels_no_goal_unless_asked_to(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.fill('[data-field=order]', '95')
    page.click('[data-send-goal]')
    confirm(page)
    page.wait_for_selector('[data-goal] [data-status]:has-text("executing")')
    page.click('text=Cancel this goal when the page is closed')
    page.fill('[data-field=order]', '94')
    page.click('[data-send-goal]')
    confirm(page)
    until(page, "() => window.goalwireLanes.hits?.filter(hit => hit[4].status === 'EXECUTING').length === 2")
    page.context.close()
    other = open_page(f'{url}?view=actions')
    until(other, "() => window.goalwireLanes?.hits?.some(hit => hit[4].status === 'CANCELED')")
    statuses = other.evaluate('() => window.goalwireLanes.hits.map(hit => hit[4].status).sort()')
    assert statuses == ['CANCELED', 'EXECUTING']


def test_read_only_shows_all_and_sends_nothing(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    _, url = stage.console('--read-only')
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.wait_for_selector('[data-send-goal][disabled]')
    assert page.locator('[data-estop]').is_hidden()
    view(page, 'services')
    row(page, '/lamp')
    page.wait_for_selector('[data-call][disabled]')
    view(page, 'parameters')
    row(page, '/robot')
    page.wait_for_selector('[data-parameter=speed][disabled]')


def test_what_is_copied_runs(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=services')
    page.context.grant_permissions(['clipboard-read', 'clipboard-write'])
    row(page, '/lamp')
    page.click('[data-field=data]')
    page.click('text=Copy as Python')
    page.wait_for_selector('.q-notification:has-text("copied")')
    program = tmp_path / 'copied.py'
    program.write_text(clipboard(page, 'import asyncio'), encoding='utf-8')
    ran = stage.program(program)
    assert 'on <b>and bright</b>' in ran.succeed()
    robot.expect('lamp True')
    page.click('text=Copy as command')
    page.wait_for_selector('.q-notification:has-text("Command copied")')
    command = clipboard(page, 'ros2 service call ')
    done = subprocess.run(
        ['sh', '-c', command.replace('ros2', f'{sys.executable} -m goalwire.cli', 1)],
        env=stage.env,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert 'bright' in done.stdout
