"""`humanoid demo --view`: the page beside the mission. tests/apps/console shows that of `up --view`."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from urllib.request import urlopen

import pytest
from helpers.patience import PATIENCE
from helpers.robot import humanoid

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

SERVED = r'the console is at (http://localhost:\d+/)'
DEMO = 120.0  # s


def shows_the_page(url: str) -> bool:
    with urlopen(url, timeout=PATIENCE) as answer:
        return b'goalwire console' in answer.read()


def test_the_demos_page_is_there_before_the_mission_and_until_its_end(world: dict[str, str]) -> None:
    pytest.importorskip('nicegui')
    with humanoid('demo', '--no-physics', '--view', env=world | {'BROWSER': 'true'}) as demo:
        url = demo.expect(f'^{SERVED}', DEMO)[1]
        demo.expect(r'^started mission', DEMO)
        demo.expect(r'^\[1/10\]', DEMO)
        assert shows_the_page(url)
        output = demo.succeed(DEMO)
    assert output.index('started robot_state_publisher') < output.index('started mission')
    assert 'without the page' not in output, 'it ended before the mission'
    assert '10 of 10 steps ended as they should' in output


def test_a_demo_whose_page_cannot_be_served_goes_on_without_it(world: dict[str, str], tmp_path: Path) -> None:
    pytest.importorskip('nicegui')
    broken = tmp_path / 'nicegui'
    broken.mkdir()
    (broken / '__init__.py').write_text("raise ImportError('it is broken')\n", encoding='utf-8')
    env = world | {'BROWSER': 'true', 'PYTHONPATH': f'{tmp_path}{os.pathsep}{world["PYTHONPATH"]}'}
    with humanoid('demo', '--no-physics', '--view', env=env) as demo:
        demo.expect('it is broken', DEMO)
        demo.expect(r'^view \(pid \d+\) ended with exit code 1; the demo goes on without the page', DEMO)
        demo.expect(r'^\[1/10\]', DEMO)
        demo.send_signal(signal.SIGINT)
        assert demo.wait(DEMO) == 1
    assert 'demo failed: stopped on request' in demo.output
    assert 'Traceback' not in demo.output


def test_a_page_that_takes_too_long_is_not_waited_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from humanoid import demo, view
    from humanoid.supervisor import Supervisor

    monkeypatch.setattr(demo, 'PAGE_WITHIN', 0.0)
    with Supervisor() as supervisor:
        supervisor.start(view.NAME, [sys.executable, '-c', 'import sys; sys.stdin.read()'])
        demo._await_page(supervisor)
    assert capsys.readouterr().out == (
        'the page was not served within 0 s; the demo goes on without the page\n'
    )


def test_the_page_has_the_same_address_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    from humanoid import view

    ran: list[list[str]] = []
    monkeypatch.setattr(sys, 'argv', ['view'])
    monkeypatch.setattr('humanoid.lifeline.hold', lambda _environment: None)
    monkeypatch.setattr('runpy.run_module', lambda *_, **__: ran.append(sys.argv))
    view.main()
    assert ran == [['goalwire', 'console', '--prefer-port', '8420']]


def test_what_the_page_needs_is_told(world: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    from humanoid import view

    monkeypatch.setattr(view, 'NEEDED', 'no_such_package')
    with pytest.raises(view.NoView, match=r'goalwire\[console\]'):
        view.command()
