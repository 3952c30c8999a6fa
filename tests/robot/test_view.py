"""`humanoid up --view`: the page in the browser beside the robot."""

from __future__ import annotations

import os
import signal
from urllib.request import urlopen

import pytest
from helpers.patience import PATIENCE
from helpers.robot import humanoid

pytestmark = pytest.mark.slow


def test_up_serves_the_page_and_goes_on_without_it(world: dict[str, str]) -> None:
    pytest.importorskip('nicegui')
    with humanoid('up', '--no-physics', '--view', env=world | {'BROWSER': 'true'}) as up:
        pid = int(up.expect(r'\[view\] pid (\d+)')[1])
        url = up.expect(r'\[view\] the console is at (http://localhost:\d+/)')[1]
        with urlopen(url, timeout=PATIENCE) as answer:
            assert b'goalwire console' in answer.read()
        os.kill(pid, signal.SIGKILL)
        up.expect(r'^view \(pid \d+\) was killed by SIGKILL; the others go on')
        up.send_signal(signal.SIGINT)
        assert up.wait() == 0


def test_what_the_page_needs_is_told(world: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    from humanoid import view

    monkeypatch.setattr(view, 'NEEDED', 'no_such_package')
    with pytest.raises(view.NoView, match=r'goalwire\[console\]'):
        view.command()
