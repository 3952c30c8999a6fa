"""A robot whose interfaces are not installed where the console runs: its nodes describe them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.away import STRANGER, knowing_away
from helpers.console import Stage, picture
from helpers.page import row

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def test_messages_and_forms_of_types_that_a_node_describes(
    stage: Stage, open_page: OpenPage, tmp_path: Path
) -> None:
    _, url = stage.console()
    page = open_page(f'{url}?view=topics')
    unknowing, stage.env = stage.env, knowing_away(stage.env, tmp_path)
    stage.program(STRANGER).expect('^ready$')
    stage.env = unknowing

    # chosen as soon as it is in the list, maybe before its type is known
    row(page, '/gauge')
    page.wait_for_selector('.gw-tree:has-text("oil")')
    page.wait_for_selector('tr[data-key="/gauge"] td:last-child:has-text("Hz")')
    assert page.locator('.gw-problem:has-text("not known here")').count() == 0
    page.click('[data-open-publish]')
    page.wait_for_selector('[data-publish]')
    picture(page, 'unknown-types')
