"""The page in a real browser, on both wires: a robot is watched, sent, called, and stopped."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.isolation import lease_variables
from helpers.page import choose, confirm, copied, drag, row, until, view
from helpers.patience import wait_for
from helpers.wires import DDS, require

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def test_a_joints_slider_stays_under_the_mouse_as_goals_end(stage: Stage, open_page: OpenPage) -> None:
    """A line for each of one's goals stands above the sliders, and a press on a slider may move the robot."""
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.fill('[data-field=order]', '90')
    page.click('[data-send-goal]')
    confirm(page)
    view(page, 'robot')
    page.wait_for_selector('[data-goal-lines] [data-cancel]')
    page.set_viewport_size({'width': 1100, 'height': 1000})  # all in sight: a browser holds what is scrolled
    slider = page.locator('[data-joint]').first  # the notification comes over the last ones
    slider.scroll_into_view_if_needed()
    slider.hover(force=True)
    place = slider.bounding_box()
    page.evaluate("() => document.querySelector('[data-goal-lines] [data-cancel]').click()")
    page.wait_for_selector('[data-goal-lines] [data-cancel]', state='detached')
    assert slider.bounding_box() == place
    page.mouse.move(5, 5)
    wait_for(lambda: slider.bounding_box()['y'] < place['y'], 'the slider further up')


@pytest.mark.parametrize('transport_name', ['rmw_zenoh_cpp', pytest.param(DDS, marks=pytest.mark.long)])
def test_a_robot_is_watched_sent_and_stopped(stage: Stage, open_page: OpenPage, transport_name: str) -> None:
    """The page knows no wire: on DDS a shorter test below sees that data, calls and parameters get by."""
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

    # Sliders move joints, by goals or by messages, once the user has said so.
    choose(page, '[data-joint-way]', '/arm/follow')
    drag(page, 'head_joint', 0.75)
    page.wait_for_selector('.q-dialog:has-text("head_joint goes to")')
    confirm(page)
    robot.expect(r'goal: head_joint to 1\.[4-7]')
    drag(page, 'head_joint', 0.6)
    robot.expect(r'goal: head_joint to 0\.[4-8]')
    until(page, '() => Math.abs(goalwireScene.poses().head[5]) > 0.15')
    choose(page, '[data-joint-way]', '/arm/trajectory')
    drag(page, 'head_joint', 0.75)
    confirm(page)
    robot.expect(r'message: head_joint to 1\.[4-7]')
    picture(page, f'joints-{transport_name}')

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


def test_services_are_called_and_calls_of_others_seen(stage: Stage, open_page: OpenPage) -> None:
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

    # A deadline ends a call; a request that was not answered is sent again where the user has said so.
    row(page, '/deaf')
    page.wait_for_selector('.gw-title:text-is("/deaf")')
    page.fill('[data-deadline]', '0.5')
    page.click('[data-call]')
    confirm(page)
    page.wait_for_selector('[data-problem]')
    row(page, '/shy')
    page.wait_for_selector('.gw-title:text-is("/shy")')
    page.fill('[data-deadline]', '20')
    page.fill('[data-attempts]', '4')
    page.click('[data-call]')
    confirm(page)
    page.wait_for_selector('[data-answer]:has-text("answer to request")')

    # Calls of others are seen where the service publishes them.
    assert page.locator('[data-events]').is_hidden()
    stage.program(PROGRAMS / 'introspected.py').expect('ready')
    row(page, '/add')
    page.wait_for_selector('.gw-title:text-is("/add")')
    page.fill('[data-field=a]', '2')
    page.fill('[data-field=b]', '3')
    page.click('[data-call]')
    confirm(page)
    page.wait_for_selector('[data-events] tr:has-text("{a: 2, b: 3}"):has-text("{sum: 5}")')
    stage.command('ros2 service call /add example_interfaces/srv/AddTwoInts "{a: 40, b: 2}"')
    page.wait_for_selector('[data-events] tr:has-text("{a: 40, b: 2}"):has-text("{sum: 42}")')
    picture(page, 'introspection')


def test_a_frame_that_began_before_the_scene_moves_nothing(stage: Stage, window: Any) -> None:
    stage.robot()
    _, url = stage.console()
    page = window.new_page()
    page.emulate_media(reduced_motion='no-preference')  # the scene moves smoothly, from frame to frame
    page.goto(f'{url}?view=robot')
    until(page, '() => window.goalwireScene?.poses?.().left_arm !== undefined')
    page.evaluate('() => Object.assign(goalwireScene, {last: performance.now() + 1000, moving: true})')
    until(page, '() => goalwireScene.last <= performance.now()')  # the next frame
    finite = 'link => Number.isFinite(link.group.position.x)'
    assert page.evaluate(f'() => [...goalwireScene.links.values()].every({finite})')
    page.close()


@pytest.mark.parametrize('transport_name', [DDS])
def test_on_dds_a_service_is_called_a_parameter_set_and_a_topic_plotted(
    stage: Stage, open_page: OpenPage, transport_name: str
) -> None:
    require(transport_name)
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=services')
    page.wait_for_selector('.gw-chip:has-text("DDS")')
    row(page, '/lamp')
    page.click('[data-field=data]')
    page.click('[data-call]')
    confirm(page)
    robot.expect('lamp True')
    page.wait_for_selector('[data-answer]:has-text("on <b>and bright</b>")')

    view(page, 'parameters')
    row(page, '/robot')
    page.fill('[data-parameter=speed]', '1.5')
    page.click('[data-set=speed]')
    confirm(page)
    page.wait_for_selector('.q-notification:has-text("speed is set")')
    assert stage.command('ros2 param get /robot speed').split()[-1] == '1.5'

    view(page, 'topics')
    row(page, '/load')
    page.click('.gw-plot-button')
    page.wait_for_selector('[data-series]:has-text("/load data")')
    chart = "getElement(document.querySelector('[data-plot]').id.slice(1)).chart"
    drawn = f'{chart}.getOption().series[0]?.data ?? []'
    until(page, f'() => ({drawn}).length > 20')
    assert all(2.0 <= value <= 4.0 for _, value in page.evaluate(f'() => {drawn}'))
    until(page, '() => /Hz/.test(document.querySelector(\'tr[data-key="/load"]\').textContent)')

    # To a publisher of latched messages, a reliable subscription to new ones would be a mistake to warn of.
    console = stage.command('ros2 topic info --verbose /texts').partition('goalwire_console')[2]
    assert 'Reliability: BEST_EFFORT' in console
    picture(page, f'topics-{DDS}')


def test_parameters_are_set_within_their_descriptors(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=parameters')
    row(page, '/robot')
    for name, typed, problem, fits in (
        ('speed', '7', '0 to 2', '1.5'),
        ('volume', '110', '0 to 100', '30'),
        ('greeting', '[1', '', "it's <b>"),
    ):
        page.wait_for_selector(f'[data-parameter={name}]')
        if problem:
            page.fill(f'[data-parameter={name}]', typed)
            page.click(f'[data-set={name}]')
            page.wait_for_selector(f'.q-notification:has-text("{problem}")')
        page.fill(f'[data-parameter={name}]', fits)
        page.eval_on_selector(f'[data-parameter={name}]', 'field => { field.dataset.before = "" }')
        page.click(f'[data-set={name}]')
        confirm(page)
        page.wait_for_selector(f'.q-notification:has-text("{name} is set")')
        page.wait_for_selector('[data-before]', state='detached')  # all are read again, into new fields
        until(
            page,
            '([name, value]) => document.querySelector(`[data-parameter=${name}]`)?.value === value',
            [name, fits],
        )
    page.wait_for_selector('[data-parameter=serial][disabled]')
    assert page.locator('[data-set=serial]').count() == 0
    shown = page.inner_text('[data-parameters]')
    assert all(text in shown for text in ('0 to 100, in steps of 10', 'loudness', 'on the plate', 'm/s'))
    picture(page, 'parameters')
    # A value between the steps passes the page, and the node says no.
    page.fill('[data-parameter=volume]', '35')
    page.click('[data-set=volume]')
    confirm(page)
    page.wait_for_selector('.q-notification.bg-negative')


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
    # A chart that has been drawn soon rests.
    page.evaluate(f"""() => {{
      const zr = {chart}.getZr();
      window.counted = {{frames: 0, drawings: 0}};
      zr.animation.on('frame', () => counted.frames++);
      zr.on('rendered', () => counted.drawings++); }}""")
    until(page, '() => counted.drawings > 5')
    counted = page.evaluate('() => counted')
    assert counted['frames'] <= 4 * counted['drawings']

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
    robot = stage.robot()
    _, url = stage.console()
    stage.program(PROGRAMS / 'intruder.py').expect('ready')
    page = open_page(f'{url}?view=graph')
    page.wait_for_selector('[data-problems] tr.bad:has-text("/quarrel"):has-text("std_msgs/msg/Float64")')
    page.wait_for_selector('[data-problems] tr.bad:has-text("/whisper"):has-text("reliable")')
    page.wait_for_selector('tr.bad:has-text("/whisper"):has-text("best effort, keep 10")')
    page.wait_for_selector('td:has-text("<img/src=x/onerror=window.hacked=1>")')
    picture(page, 'graph')
    # All of the drawing is within its card, and no symbol is stretched.
    spots = """() => {
      const chart = getElement(document.querySelector('[data-chart]').id.slice(1)).chart;
      const data = chart.getModel().getSeriesByIndex(0).getData();
      return [...Array(data.count()).keys()].map(at => {
        const [wide, , , high, x, y] = data.getItemGraphicEl(at).childAt(0).getComputedTransform();
        const isWithin = x >= 0 && y >= 0 && x <= chart.getWidth() && y <= chart.getHeight();
        return isWithin && Math.abs(wide - high) < 0.01;
      }); }"""
    found = page.evaluate(spots)
    assert len(found) > 15
    assert all(found)
    for name in ('topics', 'services', 'parameters'):
        view(page, name)
        page.wait_for_selector('td:has-text("<img/src=x/onerror=window.hacked=1>")')
    view(page, 'logs')
    script, wrong = (
        f'td:has-text("{text}")' for text in ('<script>window.hacked = 1', 'half of this is <b>')
    )
    page.wait_for_selector(script)
    page.wait_for_selector(wrong)
    picture(page, 'logs')
    choose(page, '[data-level]', 'WARN and worse')
    page.wait_for_selector(script, state='detached')
    page.wait_for_selector(wrong)
    choose(page, '[data-level]', 'All levels')
    choose(page, '[data-node]', 'robot')
    page.wait_for_selector(wrong, state='detached')
    page.wait_for_selector(script)
    choose(page, '[data-node]', 'All nodes')
    page.fill('[data-filter]', 'HALF of')
    page.wait_for_selector(script, state='detached')
    page.wait_for_selector(wrong)

    # On a phone a message lies within the page, and STOP covers nothing of the bar.
    page.set_viewport_size({'width': 390, 'height': 800})
    picture(page, 'logs-phone')
    is_whole = """told => {
      const box = document.querySelector(told).getBoundingClientRect();
      const corners = [[box.left + 2, box.top + 2], [box.right - 2, box.top + 2]];
      const isSeen = ([x, y]) => document.elementFromPoint(x, y)?.closest('.gw-shell');
      return box.width > 9 && corners.every(isSeen); }"""
    for whole in ('.gw-log-lines td.wrap', '[data-nodes]', '.gw-top .q-btn'):
        until(page, is_whole, whole)
    page.set_viewport_size({'width': 1100, 'height': 700})
    view(page, 'topics')
    row(page, '/texts')
    page.wait_for_selector('.gw-tree:has-text("javascript:window.hacked=1")')
    view(page, 'statistics')
    received = "each.cells[0].textContent === '/rosout' && Number(each.cells[1].textContent) > 1"
    until(page, f"() => [...document.querySelectorAll('tr[data-key]')].some(each => {received})")
    picture(page, 'statistics')
    # A stop that cannot be called keeps no other one from being called.
    page.click('[data-estop]')
    robot.expect('stopped')
    page.wait_for_selector('[data-stop-report=failed]:has-text("<img/src=x/onerror=window.hacked=1>/estop")')
    page.wait_for_selector('[data-stop-report]:has-text("/estop stopped after")')
    assert page.evaluate('() => window.hacked') is None
    # The subscriptions with which the console measures topics are not mismatches of the robot's.
    page.wait_for_selector('.gw-chip.bad:has-text("2 mismatches")')


def test_a_closed_page_cancels_no_goal_unless_asked_to(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    _, url = stage.console(waits={'page.site.RECONNECT_S': 1.0})
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
    page.close()
    other = open_page(f'{url}?view=actions')
    until(other, "() => window.goalwireLanes?.hits?.some(hit => hit[4].status === 'CANCELED')")
    statuses = other.evaluate('() => window.goalwireLanes.hits.map(hit => hit[4].status).sort()')
    assert statuses == ['CANCELED', 'EXECUTING']


def test_goals_are_cancelled_those_before_one_and_all(stage: Stage, open_page: OpenPage) -> None:
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.fill('[data-field=order]', '99')
    page.click('[data-send-goal]')
    page.click('text=Do not ask again for this name')
    confirm(page)
    for number in (2, 3):
        page.wait_for_selector('[data-goal] [data-status]:has-text("executing")')
        page.click('[data-send-goal]')
        until(page, '(number) => goalwireLanes.hits?.length === number', number)
    running = "goalwireLanes.hits.filter(hit => hit[4].status === 'EXECUTING').length"
    until(page, f'() => {running} === 3')
    picture(page, 'lanes')

    # The second in the lanes is chosen; it and the one before it are cancelled.
    x, y = page.evaluate("""() => {
      const [left, top, right, bottom] = goalwireLanes.hits.toSorted((a, b) => a[4].began - b[4].began)[1];
      const box = goalwireLanes.canvas.getBoundingClientRect();
      return [box.left + (left + right) / 2, box.top + (top + bottom) / 2]; }""")
    chosen = page.inner_text('[data-goal-id]')
    page.mouse.click(x, y)
    until(page, "(old) => document.querySelector('[data-goal-id]').textContent !== old", chosen)
    page.click('[data-cancel-before]')
    until(page, f'() => {running} === 1')
    last = 'goalwireLanes.hits.reduce((one, other) => one[4].began > other[4].began ? one : other)'
    assert page.evaluate(f'() => {last}[4].status') == 'EXECUTING'

    # Another client's goal is shown, and cancelled with the rest, after a question.
    other = stage.program(
        'import sys; from goalwire.apps.cli.main import run_command; sys.exit(run_command("ros2",'
        ' ["action", "send_goal", "/count", "example_interfaces/action/Fibonacci", "{order: 98}"]))'
    )
    until(page, f'() => {running} === 2')
    page.click('[data-cancel-all]')
    page.wait_for_selector('.q-dialog:has-text("whoever has sent it")')
    confirm(page)
    until(page, f'() => {running} === 0')
    assert page.evaluate('() => goalwireLanes.hits.map(hit => hit[4].status)') == ['CANCELED'] * 4
    other.wait()
    assert 'CANCELED' in other.output

    # The robot goes in the middle of a goal: the page says so.
    page.click('[data-send-goal]')
    page.wait_for_selector('[data-goal] [data-status]:has-text("executing")')
    robot.kill()
    until(page, "() => window.goalwireLanes?.hits?.some(hit => hit[4].status === 'UNKNOWN')")
    view(page, 'robot')
    page.wait_for_selector('text=No robot yet')


@pytest.mark.parametrize('transport_name', ['rmw_zenoh_cpp', pytest.param(DDS, marks=pytest.mark.long)])
def test_what_does_not_answer_is_said_to_be_old(
    stage: Stage, open_page: OpenPage, transport_name: str
) -> None:
    require(transport_name)
    stage.env |= lease_variables(10.0)  # in which a busy machine lets each program run
    robot = stage.robot()
    console, url = stage.console()
    page = open_page(f'{url}?view=robot')
    live, stale = '[data-fresh]:text-is("live")', '.gw-stale'
    page.wait_for_selector(live)
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')
    assert page.locator(stale).count() == 0

    # It is there, and says nothing: its battery and its pose have an age.
    stage.command('ros2 service call /hush std_srvs/srv/SetBool "{data: true}"')
    page.wait_for_selector('[data-battery].old:has-text("battery 62 %, ")')
    page.wait_for_selector('[data-fresh]:has-text("no news for ")')
    page.wait_for_selector('[data-gone]:has-text("It is silent")')
    page.wait_for_selector(stale)
    picture(page, f'robot-silent-{transport_name}')

    # It is killed: the page has nobody else on the wire, no battery and no STOP, and shows where it was.
    robot.kill()
    page.wait_for_selector('[data-nodes]:has-text("nobody else on the wire")')
    page.wait_for_selector('[data-gone]:has-text("It has gone")')
    page.wait_for_selector('[data-battery]', state='hidden')
    page.wait_for_selector('[data-estop]', state='hidden')
    picture(page, f'robot-gone-{transport_name}')

    # It comes back, and moves.
    stage.robot()
    page.wait_for_selector(live)
    page.wait_for_selector(stale, state='detached')
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')
    page.wait_for_selector('[data-estop]')
    pose = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(pose) => Math.abs(goalwireScene.poses().left_arm[4] - pose[4]) > 0.1', pose)

    # The console is killed: the page says so and takes no click. It goes on with the next one.
    console.kill()
    page.wait_for_selector('[data-lost]:has-text("No connection to the console")')
    assert page.evaluate("() => document.getElementById('app').inert")
    picture(page, f'console-gone-{transport_name}')
    stage.console('--port', url.rstrip('/').rpartition(':')[2])
    page.wait_for_selector('[data-lost]', state='hidden')
    page.wait_for_selector(live)
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')


def test_read_only_shows_all_and_sends_nothing_and_an_allow_list_little(
    stage: Stage, open_page: OpenPage
) -> None:
    robot = stage.robot()
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

    # An allow-list: what it names may be sent to, nothing else, but for the emergency stop.
    _, url = stage.console('--allow', '/la*', '--allow', '/robo?')
    page = open_page(f'{url}?view=services')
    row(page, '/shy')
    page.wait_for_selector('[data-call][disabled]')
    row(page, '/lamp')
    page.click('[data-call]:not([disabled])')
    confirm(page)
    robot.expect('lamp False')
    view(page, 'actions')
    row(page, '/count')
    page.wait_for_selector('[data-send-goal][disabled]')
    view(page, 'topics')
    row(page, '/say')
    page.wait_for_selector('.gw-title:has-text("/say")')
    assert page.locator('[data-open-publish]').count() == 0
    view(page, 'parameters')
    row(page, '/mischief')
    page.wait_for_selector('.gw-title:has-text("/mischief")')
    row(page, '/robot')
    page.wait_for_selector('[data-set=speed]')
    page.click('[data-estop]')
    robot.expect('stopped')


def test_what_is_copied_runs(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=services')
    page.context.grant_permissions(['clipboard-read', 'clipboard-write'])

    def run(*parts: str) -> str:
        """Run what is copied as Python, as its own process."""
        program = tmp_path / 'copied.py'
        program.write_text(copied(page, 'Copy as Python', 'import asyncio', *parts), encoding='utf-8')
        return stage.program(program).succeed()

    # A call.
    row(page, '/lamp')
    page.click('[data-field=data]')
    page.fill('[data-attempts]', '2')
    assert 'on <b>and bright</b>' in run('SetBool', 'goalwire.Retry(attempts=2, timeout=5.0)')
    robot.expect('lamp True')
    assert 'bright' in stage.command(copied(page, 'Copy as command', 'ros2 service call'))
    robot.expect('lamp True')

    # A goal.
    view(page, 'actions')
    row(page, '/go_to')
    page.fill('[data-field=x]', '0.4')
    ran = run('GoTo')
    assert 'distance_remaining' in ran
    assert 'arrived=True' in ran
    page.fill('[data-field=x]', '-0.1')
    ran = stage.command(copied(page, 'Copy as command', 'ros2 action send_goal', '-0.1'))
    assert 'distance_remaining' in ran
    assert 'SUCCEEDED' in ran
    page.locator('.gw-lanes').scroll_into_view_if_needed()  # lanes out of sight are not drawn
    until(page, "() => goalwireLanes.hits?.filter(hit => hit[4].status === 'SUCCEEDED').length === 2")

    # A message, with all that shells, YAML and Python take for their own.
    text = 'it\'s "ünï" $HOME: {a} # %s \\n'
    view(page, 'topics')
    row(page, '/say')
    page.click('[data-open-publish]')
    page.fill('[data-field=data]', text)
    page.click('[data-publish]')
    confirm(page)
    robot.expect(re.escape(f'said {text!r}'))
    run('String')
    robot.expect(re.escape(f'said {text!r}'))
    stage.command(copied(page, 'Copy as command', 'ros2 topic pub'))
    robot.expect(re.escape(f'said {text!r}'))
