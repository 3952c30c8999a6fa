"""The tests of examples/testing/, run as a user would run them."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from helpers.markdown import ROOT

pytestmark = pytest.mark.slow


def test_all_pass_in_seconds() -> None:
    command = [sys.executable, '-m', 'pytest', '-q', '-n', '0', 'examples/testing']
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout
    passed = re.search(r'^(\d+) passed in', run.stdout, re.MULTILINE)
    assert passed is not None
    assert int(passed[1]) >= 19
