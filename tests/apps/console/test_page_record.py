"""A bag is recorded with a button, in a real browser: begun, followed, ended, and what becomes of it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.console import Stage, picture
from helpers.page import until, view
from helpers.patience import BROWSER

from goalwire.rosbag2.reader import Reader

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]
LITTLE_ROOM = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
"""
"""No file of a process that runs this gets larger: its disk is full soon."""


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def _begin(page: Any, *, names: str = '', out: str = '') -> Path:
    """Fill the form, press Record, and return the bag that the page names."""
    view(page, 'record')
    page.fill('[data-record-names]', names)
    page.fill('[data-record-out]', out)
    page.click('[data-record]')
    page.wait_for_selector('[data-end-record]')
    page.wait_for_selector('[data-record-chip]')
    return Path(page.text_content('[data-record-path]'))


def _end(page: Any) -> None:
    page.click('[data-end-record]')
    page.wait_for_selector('[data-record-state]:has-text("ended")')


def _wait_for_messages(page: Any, topic: str, least: int) -> None:
    count = f'document.querySelector(`tr[data-key="{topic}"] td:nth-child(3)`)?.textContent'
    until(page, f'() => Number({count}) >= {least}')


def test_a_recording_begins_and_ends_with_a_button(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    stage.robot()
    _, url = stage.console('--record-to', str(tmp_path))
    page = open_page(url)
    path = _begin(page, out='/camera')
    _wait_for_messages(page, '/joint_states', 20)
    stage.command('ros2 service call /lamp std_srvs/srv/SetBool "{data: true}"')
    _wait_for_messages(page, '/lamp/_service_event', 1)
    picture(page, 'record')
    _end(page)
    picture(page, 'record-ended')
    page.wait_for_selector(f'[data-record-next]:has-text("goalwire console --bag {path}")')
    assert page.locator('[data-record-chip]:visible').count() == 0
    with Reader(path) as bag:
        assert bag.problems == []
        assert bag.counts['/joint_states'] >= 20
        assert bag.counts['/lamp/_service_event'] >= 2, 'request and response'
        assert bag.counts['/robot_description'] == 1, 'latched, from before the button was pressed'
        assert '/camera' not in bag.counts
        shown = page.text_content('[data-record-state]')
        assert f'{sum(bag.counts.values()):,} messages' in shown


def test_all_browsers_have_one_recording_which_outlives_their_pages(
    stage: Stage, open_page: OpenPage, tmp_path: Path
) -> None:
    stage.robot()
    console, url = stage.console('--record-to', str(tmp_path))
    first = open_page(url)
    path = _begin(first, names='/joint_states, /tf*')
    second = open_page(f'{url}?view=logs')
    first.close()
    second.click('[data-record-chip]')
    _wait_for_messages(second, '/tf', 5)
    assert second.text_content('[data-record-path]') == str(path)
    assert not second.is_visible('[data-record]'), 'one at a time'

    console.send_signal(signal.SIGINT)
    console.wait(BROWSER)
    with Reader(path) as bag:
        assert bag.problems == [], 'it was closed in order'
        assert set(bag.counts) == {'/joint_states', '/tf'}


@pytest.mark.long
def test_a_full_disk_is_told_and_the_next_recording_begins(
    stage: Stage, open_page: OpenPage, tmp_path: Path
) -> None:
    """In each run tests/apps/bag/test_recorder.py and tests/rosbag2/test_bags.py have a full disk."""
    stage.robot()
    _, url = stage.console('--record-to', str(tmp_path), first=LITTLE_ROOM)
    page = open_page(url)
    path = _begin(page)
    page.wait_for_selector('[data-record-problem]:has-text("cannot be written: File too large")')
    page.wait_for_selector('[data-record-lost]:has-text("not in the bag")')
    page.wait_for_selector('[data-record-chip]:has-text("recording failed")')
    picture(page, 'record-failed')
    with Reader(path) as bag:
        assert sum(bag.counts.values()) > 0, 'what had room is there'
    after = _begin(page, names='/load')
    assert after != path
    _wait_for_messages(page, '/load', 5)
    _end(page)


def test_a_console_that_is_read_only_records_nothing(
    stage: Stage, open_page: OpenPage, tmp_path: Path
) -> None:
    _, url = stage.console('--read-only', '--record-to', str(tmp_path / 'bags'))
    page = open_page(f'{url}?view=record')
    page.wait_for_selector('[data-record][disabled]')
    assert not (tmp_path / 'bags').exists()
