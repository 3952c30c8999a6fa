"""The page while the console does not answer, and after that: STOP, its report, and what was typed."""

from __future__ import annotations

import json
import signal
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

import pytest
from helpers.console import DATA, PROGRAMS, Stage, picture
from helpers.page import choose, confirm, row, until, view
from helpers.patience import PATIENCE, wait_for
from helpers.processes import Program

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

ASKED = 'robot: asked True'
STATES = """() => {
  window.states = [];
  const tell = state => window.states.push([state, performance.now()]);
  goalwireStop.$watch('report.state', tell, { flush: 'sync' }); }"""
CONNECT_AGAIN = """() => {
  socket.io.opts.query.next_message_id = window.nextMessageId; // as before each attempt of its own
  socket.io.reconnection(true);
  socket.connect(); }"""
TIMEOUTS = """() => {
  socket.io.timeout(1000);
  window.timeouts = 0;
  socket.io.on('error', error => { window.timeouts += error.message === 'timeout'; }); }"""


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def robot(stage: Stage) -> Program:
    """Start a robot that can be stopped."""
    started = stage.program(PROGRAMS / 'stoppable.py', str(DATA / 'robot.urdf'), 'alice', '1.0')
    started.expect('ready')
    return started


@contextmanager
def hung(console: Program) -> Iterator[None]:
    """Have the console do nothing meanwhile."""
    console.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        console.send_signal(signal.SIGCONT)


def watch_alice(stage: Stage, open_page: OpenPage) -> tuple[Program, Program, Any]:
    """Start a robot and a console, and open a page that can stop the robot."""
    alice = robot(stage)
    console, url = stage.console()
    page = open_page(f'{url}?view=services&robot=/alice')
    page.wait_for_selector('[data-estop]')
    return alice, console, page


def seconds_until_failed(page: Any) -> float:
    """Return how long the page took to say that the last press has failed."""
    (first, began), (second, ended), *_ = page.evaluate('() => window.states.slice(-2)')
    assert (first, second) == ('stopping', 'failed')
    return float(ended - began) / 1000


def press(url: str, values: Any, headers: dict[str, str] | None = None) -> tuple[int, str]:
    """Send a press as a page does, without a web socket; return the status and the answer."""
    return post(url, json.dumps(values).encode(), headers)


def post(url: str, body: bytes, headers: dict[str, str] | None = None) -> tuple[int, str]:
    """Send these bytes as a press; return the status and the answer."""
    request = urllib.request.Request(f'{url}console/stop', body, headers or {}, method='POST')
    try:
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_a_request_stops_without_a_web_socket_and_a_press_is_done_once(stage: Stage) -> None:
    alice = robot(stage)
    _, url = stage.console()
    pressed: dict[str, Any] = {'press': 'one', 'robot': '/alice', 'all': False}

    def is_stopped() -> bool:
        """Press anew until the console has seen the robot."""
        pressed['press'] += '+'
        status, text = press(url, pressed)
        assert status == 200
        answers = [json.loads(line) for line in text.split('\n') if line]
        return bool(answers[-1]['ok']) and answers[-1]['service'] == '/alice/emergency_stop'

    wait_for(is_stopped, 'a robot that is stopped')
    alice.expect(ASKED)
    asked = alice.output.count(ASKED)
    first = press(url, pressed)
    assert 'stopped after' in first[1]
    assert press(url, pressed | {'again': True}) == first
    assert alice.output.count(ASKED) == asked, 'a press that is known is not done again'
    assert press(url, pressed | {'press': 'another', 'again': True})[0] == 404
    assert 'does not see the robot' in press(url, pressed | {'press': 'bob', 'robot': '/bob'})[1]
    no_ids: list[Any] = [[], {}, pressed | {'press': ''}, pressed | {'press': 'x' * 65}]
    for wrong in (*no_ids, pressed | {'robot': 7}):
        assert press(url, wrong)[0] == 400
    for broken in (b'', b'{', b'\xff\xfe', b'[' * 100_000):
        assert post(url, broken)[0] == 400
    assert press(url, pressed, {'Origin': 'http://elsewhere.example'})[0] == 403
    assert press(f'{url}../console/', pressed)[0] in {404, 405}


def test_a_console_that_hangs_is_told_and_the_late_answer_to_stop_is_shown(
    stage: Stage, open_page: OpenPage
) -> None:
    alice, console, page = watch_alice(stage, open_page)
    page.evaluate(STATES)
    page.evaluate(TIMEOUTS)
    page.evaluate('() => { window.same = true; }')
    with hung(console):
        page.keyboard.press('Pause')  # the page does not know yet that nobody answers
        page.wait_for_selector('[data-stop-report=failed]:has-text("no answer within 1 s")')
        assert 0.9 < seconds_until_failed(page) < 3
        page.click('[data-dismiss]')
        page.wait_for_selector('[data-lost]:has-text("No connection to the console")')
        picture(page, 'stop-lost')
        page.click('[data-estop]')
        page.wait_for_selector('[data-stop-report=failed]')
        assert 0.9 < seconds_until_failed(page) < 3
        until(page, '() => window.timeouts >= 2')  # at each NiceGUI's own script would load the page anew
        assert alice.output.count(ASKED) == 0
    page.wait_for_selector('[data-lost]', state='hidden')
    page.wait_for_selector('[data-stop-report=late]:has-text("the robot was stopped late")')
    page.wait_for_selector('[data-banner=stopped]')
    assert page.evaluate('() => window.same'), 'it is the same page'
    picture(page, 'stop-late')
    assert alice.output.count(ASKED) == 2, 'each press was done once'


def test_a_browser_without_a_network_says_at_once_that_stop_failed(stage: Stage, open_page: OpenPage) -> None:
    alice, _, page = watch_alice(stage, open_page)
    page.fill('[data-filter]', 'stop')
    page.evaluate(STATES)
    page.evaluate('() => { window.same = true; }')
    page.context.set_offline(True)
    try:
        page.wait_for_selector('[data-lost]')
        page.keyboard.press('Pause')
        page.wait_for_selector('[data-stop-report=failed]:has-text("the console cannot be reached")')
        assert seconds_until_failed(page) < 1
    finally:
        page.context.set_offline(False)
    page.wait_for_selector('[data-lost]', state='hidden')
    page.wait_for_selector('[data-stop-report=failed]')  # it stays
    assert page.input_value('[data-filter]') == 'stop'
    page.click('[data-estop]')
    alice.expect(ASKED)
    page.wait_for_selector('[data-stop-report=stopped]')
    assert alice.output.count(ASKED) == 1, 'the press that failed is not done later'
    assert page.evaluate('() => window.same')


def test_a_press_goes_on_by_a_request_if_the_web_socket_is_lost(stage: Stage, open_page: OpenPage) -> None:
    alice, _, page = watch_alice(stage, open_page)
    page.evaluate('() => { socket.io.reconnection(false); socket.io.engine.close(); }')
    page.wait_for_selector('[data-lost]')
    page.click('[data-estop]')
    alice.expect(ASKED)
    page.wait_for_selector('[data-stop-report=stopped]:has-text("/alice/emergency_stop stopped after")')
    picture(page, 'stop-without-web-socket')
    page.evaluate(CONNECT_AGAIN)
    page.wait_for_selector('[data-lost]', state='hidden')
    page.wait_for_selector('[data-banner=stopped]')
    assert alice.output.count(ASKED) == 1, 'both ways together are one press'


def test_a_report_outlives_a_reload_and_its_late_answer_too(stage: Stage, open_page: OpenPage) -> None:
    alice, console, page = watch_alice(stage, open_page)
    with hung(console):
        page.keyboard.press('Pause')
        page.wait_for_selector('[data-stop-report=failed]')
        page.evaluate('() => void setTimeout(() => location.reload())')
    alice.expect(ASKED)
    page.wait_for_selector('[data-stop-report=late]:has-text("/alice/emergency_stop stopped after")')
    assert alice.output.count(ASKED) == 1

    # Another console at that address knows nothing of the press, and stops nothing for it.
    page.click('[data-dismiss]')
    with hung(console):
        page.keyboard.press('Pause')
        page.wait_for_selector('[data-stop-report=failed]')
        console.kill()
    page.evaluate('() => { window.same = true; }')
    stage.console('--port', str(urlsplit(page.url).port))
    until(page, '() => window.same === undefined')
    page.wait_for_selector('[data-stop-report=failed]:has-text("the robot may still move")')
    page.wait_for_selector('[data-banner=stopped]')
    assert alice.output.count(ASKED) == 1
    page.reload()
    page.wait_for_selector('[data-stop-report=failed]')
    page.click('[data-dismiss]')
    page.reload()
    page.wait_for_selector('[data-banner=stopped]')
    assert page.locator('[data-stop-report]').count() == 0


def again(page: Any, do: Callable[[], object]) -> None:
    """Do what has the page loaded anew, and wait until it is."""
    page.evaluate('() => { window.same = true; }')
    do()
    until(page, '() => window.same === undefined')


def test_half_filled_forms_outlive_a_console_that_is_started_anew(stage: Stage, open_page: OpenPage) -> None:
    stage.program(PROGRAMS / 'assembler.py').expect('ready')
    console, url = stage.console()
    page = open_page(f'{url}?view=services')
    row(page, '/fill')
    page.fill('[data-field=speed]', 'fast')  # it does not fit, and is kept all the same
    choose(page, '[data-field=mode]', 'SLOW (2)')
    page.click('[data-field=careful]')
    page.click('[data-add=parts]')
    page.wait_for_selector('[data-field="parts[0].label"]')
    page.click('[data-add=parts]')
    # The first field of the new item gets the focus.
    until(page, """() => document.activeElement?.matches('[data-field="parts[1].size"]')""")
    page.fill('[data-field="parts[1].label"]', 'second')
    page.fill('[data-deadline]', '3')
    console.kill()
    page.wait_for_selector('[data-lost]')
    picture(page, 'form-lost')
    again(page, lambda: stage.console('--port', str(urlsplit(page.url).port)))
    page.wait_for_selector('.gw-title:text-is("/fill")')
    until(page, """() => document.querySelector('[data-field="parts[1].label"]')?.value === 'second'""")
    picture(page, 'form-kept')
    assert page.input_value('[data-field=speed]') == 'fast'
    assert page.input_value('[data-field=mode]') == 'SLOW (2)'
    assert page.get_attribute('[data-field=careful]', 'aria-checked') == 'false'
    assert float(page.input_value('[data-deadline]')) == 3
    page.fill('[data-field=speed]', '0.25')
    page.click('[data-call]')
    text = page.inner_text('.q-dialog [data-confirm]')
    for part in ('mode: 2', 'speed: 0.25', 'careful: false', 'label: second'):
        assert part in text
    page.click('.q-dialog >> text=Cancel')
    page.wait_for_selector('.q-dialog', state='detached')

    # As YAML, over a reload at once.
    page.click('[data-toggle-yaml]')
    page.wait_for_selector('[data-yaml]')
    page.fill('[data-yaml]', 'speed: 0.5\nname: [unfinished')
    again(page, page.reload)
    page.wait_for_selector('[data-yaml]')
    assert page.input_value('[data-yaml]') == 'speed: 0.5\nname: [unfinished'

    # A visitor who turns to something else has left the form.
    view(page, 'logs')
    again(page, page.reload)
    view(page, 'services')
    page.wait_for_selector('text=Choose a service to call it.')


def test_a_form_whose_service_is_away_waits_until_the_visitor_turns_to_another_one(
    stage: Stage, open_page: OpenPage
) -> None:
    stage.robot()
    _, url = stage.console()
    for turns_away in (False, True):
        assembler = stage.program(PROGRAMS / 'assembler.py')
        assembler.expect('ready')
        page = open_page(f'{url}?view=services')
        row(page, '/fill')
        page.fill('[data-field=speed]', 'fast')
        assembler.kill()
        page.wait_for_selector('tr[data-key="/fill"]', state='detached')
        again(page, page.reload)
        page.wait_for_selector('text=Choose a service to call it.')
        if turns_away:
            row(page, '/lamp')
        back = stage.program(PROGRAMS / 'assembler.py')
        page.wait_for_selector('tr[data-key="/fill"]')
        page.fill('[data-filter]', 'fill')
        page.wait_for_selector('tr[data-key="/lamp"]', state='detached')
        page.wait_for_selector(f'.gw-title:text-is("{"/lamp" if turns_away else "/fill"}")')
        if not turns_away:
            until(page, "() => document.querySelector('[data-field=speed]')?.value === 'fast'")
        back.kill()


@pytest.mark.long
def test_half_filled_goals_messages_and_parameters_outlive_a_reload(
    stage: Stage, open_page: OpenPage
) -> None:
    """Their forms are those of services, which a test above has in each run."""
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.fill('[data-field=order]', '7')
    again(page, page.reload)
    until(page, "() => document.querySelector('[data-field=order]')?.value === '7'")
    page.click('[data-send-goal]')
    page.wait_for_selector('.q-dialog:has-text("order: 7")')
    page.click('.q-dialog >> text=Cancel')
    page.wait_for_selector('.q-dialog', state='detached')
    view(page, 'parameters')
    row(page, '/robot')
    page.fill('[data-parameter=speed]', '0.75')
    again(page, page.reload)
    until(page, "() => document.querySelector('[data-parameter=speed]')?.value === '0.75'")
    page.click('[data-set=speed]')
    page.wait_for_selector('.q-dialog:has-text("ros2 param set /robot speed 0.75")')
    page.click('.q-dialog >> text=Cancel')
    page.wait_for_selector('.q-dialog', state='detached')
    view(page, 'topics')
    row(page, '/load')
    page.click('[data-open-publish]')
    page.fill('[data-field=data]', '42')
    again(page, page.reload)
    until(page, "() => document.querySelector('[data-field=data]')?.value === '42'")


def test_what_was_typed_into_a_dead_connection_arrives_after_it(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=actions')
    row(page, '/count')
    page.fill('[data-field=order]', '5')
    page.click('[data-send-goal]')
    page.wait_for_selector('.q-dialog:has-text("order: 5")')
    page.click('.q-dialog >> text=Cancel')
    page.wait_for_selector('.q-dialog', state='detached')
    page.evaluate('() => { window.same = true; socket.io.engine.transport.ws.send = () => {}; }')
    page.fill('[data-field=order]', '8')
    page.evaluate('() => socket.io.engine.close()')
    page.wait_for_selector('[data-lost]')
    page.wait_for_selector('[data-lost]', state='hidden')
    page.click('[data-send-goal]')
    page.wait_for_selector('.q-dialog:has-text("order: 8")')
    confirm(page)
    page.wait_for_selector('[data-goal] [data-status]')
    assert page.evaluate('() => window.same')


def test_a_goal_from_the_floor_is_sent_as_it_is_shown(stage: Stage, open_page: OpenPage) -> None:
    alice = robot(stage)
    _, url = stage.console()
    page = open_page(f'{url}?view=robot&robot=/alice')
    until(page, '() => window.goalwireScene?.poses?.().base_link !== undefined')
    page.wait_for_selector('[data-way]:visible')
    box = page.locator('.gw-scene canvas').bounding_box()
    page.mouse.click(box['x'] + box['width'] / 2, box['y'] + box['height'] * 0.8)
    page.click('.q-dialog >> text=The goal in full')
    page.wait_for_selector('.q-dialog [data-field=x]:visible')
    page.evaluate('() => { socket.io.engine.transport.ws.send = () => {}; }')
    page.fill('.q-dialog [data-field=x]', '8.5')
    page.evaluate('() => socket.io.engine.close()')
    page.wait_for_selector('[data-lost]')
    page.wait_for_selector('[data-lost]', state='hidden')
    confirm(page)
    alice.expect('robot: goes to 8.5')
