"""The Missions view in a real browser: people answer what missions ask, and the robot goes on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.console import CONSOLE, Stage, picture
from helpers.page import confirm, view
from helpers.patience import BROWSER, wait_for

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


MISSIONS = Path(__file__).parents[2] / 'missions' / 'programs'
ASKS = """
from goalwire.missions import mission

@mission(resume='auto')
async def ask(m):
    return await m.approve('carry 7 kg?')
"""


def run_mission(stage: Stage, journal: Path, name: str, *arguments: str) -> Any:
    """Start a runner of one mission."""
    command = ('mission', 'run', '-j', str(journal), '--id', 'm', name, *arguments)
    return stage.program(CONSOLE, *command)


def watch_a_question(stage: Stage, open_page: OpenPage, folder: Path) -> tuple[Any, Any]:
    """Start a mission that asks, and a page that shows it; return its runner and the page."""
    journal = folder / 'missions.db'
    (folder / 'asks.py').write_text(ASKS, encoding='utf-8')
    runner = run_mission(stage, journal, f'{folder / "asks.py"}:ask')
    runner.expect('asks: carry 7 kg', BROWSER)
    _, url = stage.console('--missions', str(journal))
    page = open_page(url)
    view(page, 'missions')
    return runner, page


def test_an_approval_is_given_by_a_button(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    runner, page = watch_a_question(stage, open_page, tmp_path)
    page.wait_for_selector('[data-question=m]:has-text("carry 7 kg?")')
    page.click('[data-question=m] [data-say=yes]')
    runner.expect('^Mission succeeded: True', BROWSER)
    page.wait_for_selector('[data-question]', state='detached')
    page.wait_for_selector('tr[data-key=m]:has-text("succeeded")')


def test_a_lost_step_is_shown_with_its_evidence_and_done_again_after_a_question(
    stage: Stage, open_page: OpenPage, tmp_path: Path
) -> None:
    journal, executions = tmp_path / 'missions.db', tmp_path / 'executions.txt'
    server = (str(executions), '0.5', '5.0', str(tmp_path / 'drive.goals'))
    base = stage.program(MISSIONS / 'base.py', *server)
    base.expect('^ready$', BROWSER)
    _, url = stage.console('--missions', str(journal))
    page = open_page(url)
    view(page, 'missions')
    page.wait_for_selector('[data-mission-problem]:has-text("there is no journal")')
    runner = run_mission(stage, journal, f'{MISSIONS / "rounds.py"}:rounds', '3')
    runner.expect('step 2: goal drive begins', BROWSER)
    wait_for(lambda: executions.read_text(encoding='utf-8').count('begun') == 2, 'the second drive')
    base.kill()
    stage.program(MISSIONS / 'base.py', *server).expect('^ready$', BROWSER)
    page.wait_for_selector('[data-question=m]:has-text("it was begun, then its server died")')
    picture(page, 'missions')
    page.click('[data-question=m] [data-say=again]')
    confirm(page)
    runner.expect('^Mission succeeded: 3', BROWSER)
    assert executions.read_text(encoding='utf-8').count('begun') == 4


def test_an_open_mission_whose_runner_was_killed_says_that_nobody_runs_it(
    stage: Stage, open_page: OpenPage, tmp_path: Path
) -> None:
    runner, page = watch_a_question(stage, open_page, tmp_path)
    page.wait_for_selector('tr[data-key=m]:has-text("approval")')
    assert page.locator('text=obody runs it').count() == 0
    runner.kill()
    page.wait_for_selector('tr[data-key=m]:has-text("nobody runs it: carry 7 kg?")')
    page.wait_for_selector(
        '[data-question=m]:has-text("its runner takes the answer when it is started again")'
    )
    page.click('[data-question=m] [data-say=yes]')
    run_mission(stage, tmp_path / 'missions.db', f'{tmp_path / "asks.py"}:ask').expect(
        '^Mission succeeded: True', BROWSER
    )
    page.wait_for_selector('tr[data-key=m]:has-text("succeeded")')
    assert page.locator('text=obody runs it').count() == 0


def test_a_console_that_only_looks_has_no_buttons(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    journal = tmp_path / 'missions.db'
    (tmp_path / 'asks.py').write_text(ASKS, encoding='utf-8')
    run_mission(stage, journal, f'{tmp_path / "asks.py"}:ask').expect('asks: carry 7 kg', BROWSER)
    _, url = stage.console('--read-only', '--missions', str(journal))
    page = open_page(url)
    view(page, 'missions')
    page.wait_for_selector('[data-question=m]:has-text("carry 7 kg?")')
    assert page.locator('[data-say]').count() == 0
