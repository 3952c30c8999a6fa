"""Forms in a real browser: the server receives the values that a person fills in, field by field."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import copied, row, view
from helpers.patience import BROWSER_MS, wait_for

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

TYPED = {
    'small': '-7',
    'speed': '2.25',
    'name': 'äé',
    'due': '1700000000.000000005',
    'three': '7, 0x8, 9',
    'few': '-1, 300',
    'lengths': '0.5, 1e-3',
    'names': """plain, "with, comma", it's, '', 'isn''t', say "hi", {a: b} # c, "two\\nlines", 12""",
    'tags': 'yes, äé',
    'switches': 'true, false',
    'part.label': 'it\'s "ünï" $HOME: {a} # %s \\n',
    'part.holes[0].depth': '1',
    'part.holes[1].depth': '2.5',
    'part.holes[1].at': '3, -4',
    'parts[0].label': 'first',
    'parts[1].size': '1e2',
    'pair[1].label': 'right',
}
SENT: dict[str, Any] = {
    'mode': 2,
    'small': -7,
    'speed': 2.25,
    'name': 'äé',
    'careful': False,
    'due': {'sec': 1700000000, 'nanosec': 5},
    'three': [7, 8, 9],
    'few': [-1, 300],
    'lengths': [0.5, 0.001],
    'names': [
        'plain', 'with, comma', "it's", '', "isn't", 'say "hi"', '{a: b} # c', 'two\nlines', '12',
    ],
    'tags': ['yes', 'äé'],
    'switches': [True, False],
    'part': {
        'size': 1.5,
        'label': TYPED['part.label'],
        'holes': [{'depth': 2.5, 'at': [3, -4]}],
    },
    'parts': [{'size': 1.5, 'label': 'first', 'holes': []}, {'size': 100.0, 'label': '', 'holes': []}],
    'pair': [{'size': 1.5, 'label': '', 'holes': []}, {'size': 1.5, 'label': 'right', 'holes': []}],
    'spares': [],
}  # fmt: skip
DEFAULTS: dict[str, Any] = {
    'mode': 1,
    'small': 0,
    'speed': 0.5,
    'name': 'abc',
    'careful': True,
    'due': {'sec': 0, 'nanosec': 0},
    'three': [0, 0, 0],
    **{name: [] for name in ('few', 'lengths', 'names', 'tags', 'switches', 'parts', 'spares')},
    'part': {'size': 1.5, 'label': '', 'holes': []},
    'pair': [{'size': 1.5, 'label': '', 'holes': []}] * 2,
}
REFUSED = [
    ('small', '128', 'give a number from -128 to 127'),
    ('three', '1, 2', 'there must be 3 items, not 2'),
    ('few', '1, 99999', '[1]: give a number from -32768 to 32767'),
    ('part.holes[0].at', '1', 'there must be 2 items'),
]
"""One of each kind of field. Which values do not fit is tested in test_form_model.py, without a browser."""
MORE_REFUSED = [
    ('small', '1.5', 'give a whole number'),
    ('small', '', 'give a whole number'),
    ('speed', '1e39', 'give a number from -3.4'),
    ('name', 'abcde', '4 characters at most, not 5'),
    ('name', 'äéü', '4 bytes at most, not 6'),
    ('due', 'soon', 'give a number'),
    ('few', '1, 2, 3', 'there may be 2 items at most, not 3'),
    ('names', 'a, "b', '[1]: what begins with a quotation mark must end with it'),
    ('names', 'a,, b', "[1]: there is nothing before the comma; an empty text is ''"),
    ('tags', 'a, abcdef', '[1]: 5 characters at most'),
    ('switches', 'maybe', '[0]: give true or false'),
    ('parts[1].size', 'x', 'give a number'),
]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def input_of(path: str) -> str:
    return f'[data-field="{path}"]'


def begin(stage: Stage, open_page: OpenPage, view: str, key: str) -> tuple[Any, Any]:
    """Start server, console and page; return the server, and the page with the form."""
    server = stage.program(PROGRAMS / 'assembler.py')
    server.expect('ready')
    _, url = stage.console()
    page = open_page(f'{url}?view={view}')
    page.context.grant_permissions(['clipboard-read', 'clipboard-write'])
    page.click(f'tr[data-key="{key}"]')
    return server, page


def choose_mode(page: Any, option: str) -> None:
    page.locator('.q-select', has=page.locator(input_of('mode'))).click()
    page.click(f'.q-menu .q-item:has-text("{option}")')
    page.wait_for_selector('.q-menu', state='detached')  # while it fades it takes what the mouse does


def add(page: Any, path: str, count: int = 1) -> None:
    """Add items to a list; the cursor goes to the first field of each."""
    for number in range(count):
        page.click(f'[data-add="{path}"]')
        first = page.wait_for_selector(f'[data-field^="{path}[{number}]"]')
        page.wait_for_function('(field) => document.activeElement === field', arg=first, timeout=BROWSER_MS)


def fill_in(page: Any) -> None:
    """Fill all in as a person would."""
    choose_mode(page, 'SLOW (2)')
    page.click(input_of('careful'))
    add(page, 'part.holes', 2)
    add(page, 'parts', 2)
    for path, text in TYPED.items():
        page.fill(input_of(path), text)
    page.click('[data-remove="part.holes[0]"]')
    page.wait_for_selector(input_of('part.holes[1].depth'), state='detached')


def confirm(page: Any) -> None:
    page.click('.q-dialog [data-send]')
    page.wait_for_selector('.q-dialog', state='detached')


def shown(page: Any) -> dict[str, str]:
    """Return what the form's fields show."""
    return dict(
        page.eval_on_selector_all(
            '.gw-form input[data-field], .gw-form textarea[data-field]',
            'all => all.map(each => [each.dataset.field, each.value])',
        )
    )


def as_yaml(page: Any) -> dict[str, Any]:
    """Show the form as YAML and return what that says, and show the form again."""
    page.click('[data-toggle-yaml]')
    page.wait_for_selector('[data-yaml]')
    values = yaml.safe_load(page.input_value('[data-yaml]'))
    page.click('[data-toggle-yaml]')
    page.wait_for_selector(input_of('small'))
    assert isinstance(values, dict)
    return values


def heard(server: Any, what: str) -> dict[str, Any]:
    """Return what the server received next."""
    values = json.loads(server.expect(rf'^{what} (\{{.*\}})$')[1])
    assert isinstance(values, dict)
    return values


def test_a_service_receives_what_was_filled_in(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    server, page = begin(stage, open_page, 'services', '/fill')
    page.wait_for_selector(input_of('small'))
    assert as_yaml(page) == DEFAULTS

    # Lists of messages: a fixed one has no buttons, a full one says why it takes no more.
    assert page.locator('[data-add="pair"], [data-remove^="pair"]:not([data-remove*="holes"])').count() == 0
    fill_in(page)
    full = page.locator('[data-add="parts"]')
    assert full.is_disabled()
    assert full.get_attribute('aria-label') == 'parts is full: 2 at most'
    full.locator('xpath=..').hover()
    page.wait_for_selector('.q-tooltip:has-text("parts is full: 2 at most")')
    page.click('[data-remove="parts[1]"]')
    page.wait_for_selector('[data-add="parts"]:not([disabled])')
    assert page.get_attribute('[data-add="parts"]', 'aria-label') == 'Add one to parts'
    add_again = page.locator(input_of('parts[1].size'))
    page.click('[data-add="parts"]')
    add_again.fill(TYPED['parts[1].size'])
    assert page.get_attribute(input_of('part.size'), 'aria-label') == 'part.size [m]'
    picture(page, 'form')

    # YAML has the same, and the form after it.
    before = shown(page)
    assert as_yaml(page) == SENT
    after = shown(page)
    assert after.keys() == before.keys()
    assert {path: after[path] for path in ('names', 'due', 'few', 'parts[1].size')} == {
        'names': """plain, "with, comma", it's, '', isn't, say "hi", {a: b} # c, "two\\nlines", 12""",
        'due': '1700000000.000000005',
        'few': '-1, 300',
        'parts[1].size': '100.0',
    }

    page.click('[data-call]')
    confirm(page)
    assert heard(server, 'service') == SENT
    page.wait_for_selector('[data-answer]:has-text("äé")')
    page.click('text=Copy as Python')
    read = partial(page.evaluate, '() => navigator.clipboard.readText()')
    wait_for(lambda: 'import asyncio' in read(), 'a copied program')
    (tmp_path / 'copied.py').write_text(read(), encoding='utf-8')
    assert 'äé' in stage.program(tmp_path / 'copied.py').succeed()
    assert heard(server, 'service') == SENT

    # A line that is taken out of the YAML is the default again. What was sent before comes back as it was.
    page.click('[data-toggle-yaml]')
    page.fill('[data-yaml]', '{spares: [{label: last}], mode: 0}')
    page.click('[data-toggle-yaml]')
    page.wait_for_selector(input_of('spares[0].size'))
    other = {**DEFAULTS, 'mode': 0, 'spares': [{'size': 1.5, 'label': 'last', 'holes': []}]}
    assert as_yaml(page) == other
    page.click('[data-call]')
    confirm(page)
    assert heard(server, 'service') == other
    page.click('tr:has-text("1700000000")')
    page.wait_for_selector(input_of('parts[1].size'))
    assert shown(page) == after
    page.click('tr:has-text("last")')
    page.wait_for_selector(input_of('spares[0].size'))
    page.click('[data-call]')
    confirm(page)
    assert heard(server, 'service') == other


@pytest.mark.long
def test_a_copied_command_sends_the_time_at_which_it_runs(stage: Stage, open_page: OpenPage) -> None:
    """In each run test_logic.py reads such commands, and test_page.py runs copied ones."""
    server, page = begin(stage, open_page, 'services', '/fill')
    began = 0

    def run(what: str, *parts: str) -> dict[str, Any]:
        """Run what is copied as a command in a shell, and return what the server received."""
        nonlocal began
        command = copied(page, 'Copy as command', f'ros2 {what}', *parts)
        began = int(time.time())
        stage.command(command)
        return heard(server, what.partition(' ')[0].replace('action', 'goal'))

    def is_now(stamp: dict[str, int]) -> bool:
        return began <= stamp['sec'] <= time.time()

    page.fill(input_of('due'), 'now')
    page.fill(input_of('name'), "it's")
    sent = run('service call', 'due: now')
    assert is_now(sent['due'])
    assert sent['name'] == "it's"

    view(page, 'actions')
    row(page, '/assemble')
    page.fill(input_of('due'), 'auto')
    assert is_now(run('action send_goal', 'due: now')['due'])

    view(page, 'topics')
    row(page, '/place')
    page.click('[data-open-publish]')
    assert page.input_value(input_of('header.stamp')) == 'now'
    page.fill(input_of('header.frame_id'), 'map')
    page.fill(input_of('pose.position.x'), '0.5')
    picture(page, 'now')
    place = run('topic pub', 'stamp: now')
    assert is_now(place['header']['stamp'])
    assert (place['header']['frame_id'], place['pose']['position']['x']) == ('map', 0.5)


def refuse(page: Any, path: str, text: str, problem: str) -> None:
    """Fill in what does not fit: the field says so, sending leads back to it; then fill in what was there."""
    fits = page.input_value(input_of(path))
    page.fill(input_of(path), text)
    field = page.locator('.q-field', has=page.locator(input_of(path)))
    field.locator('[role=alert]', has_text=problem).wait_for()
    page.click('[data-send-goal]')
    page.wait_for_selector(f'.q-notification:has-text("{path}")')
    page.wait_for_function(
        '(path) => document.activeElement.dataset.field === path', arg=path, timeout=BROWSER_MS
    )
    if path == 'few':
        picture(page, 'refused')
    page.fill(input_of(path), fits)
    field.locator('[role=alert]').wait_for(state='detached')


@pytest.mark.long
def test_each_field_says_what_does_not_fit(stage: Stage, open_page: OpenPage) -> None:
    """The same for every kind of value; in each run one of each kind of field is refused below."""
    server, page = begin(stage, open_page, 'actions', '/assemble')
    fill_in(page)
    for path, text, problem in MORE_REFUSED:
        refuse(page, path, text, problem)
    page.click('[data-send-goal]')
    confirm(page)
    assert heard(server, 'goal') == SENT


def test_an_action_receives_what_was_filled_in_and_nothing_that_was_refused(
    stage: Stage, open_page: OpenPage
) -> None:
    server, page = begin(stage, open_page, 'actions', '/assemble')
    fill_in(page)
    for path, text, problem in REFUSED:
        refuse(page, path, text, problem)
    page.click('[data-send-goal]')
    confirm(page)
    assert heard(server, 'goal') == SENT
    page.wait_for_selector('[data-goal] [data-status]:has-text("succeeded")')
    page.wait_for_selector('[data-result]:has-text("äé")')

    # Another goal; the form begins with that when the action is chosen anew, and the first one comes back.
    page.fill(input_of('few'), '')
    page.fill(input_of('pair[0].label'), 'left')
    page.click('[data-send-goal]')
    confirm(page)
    other = {**SENT, 'few': [], 'pair': [{**SENT['pair'][0], 'label': 'left'}, SENT['pair'][1]]}
    assert heard(server, 'goal') == other
    view(page, 'logs')
    view(page, 'actions')
    page.click('tr[data-key="/assemble"]')
    page.wait_for_selector(input_of('small'))
    assert as_yaml(page) == other
    page.click('tr:has-text("few: [-1, 300]")')
    page.wait_for_function(
        '(field) => document.querySelector(field).value === "-1, 300"',
        arg=input_of('few'),
        timeout=BROWSER_MS,
    )
    page.click('[data-send-goal]')
    confirm(page)
    assert heard(server, 'goal') == SENT
    assert server.output.count('goal {') == 3
