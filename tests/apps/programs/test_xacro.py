"""xacro: the package of PyPI does the work; without it one is told what to install."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from apps.programs.conftest import Run

from goalwire.apps.programs.xacro import ADVICE, main

MACRO = Path(__file__).parents[2] / 'launching' / 'public' / 'arm.urdf.xacro'


def test_a_file_is_made_a_urdf(run: Run) -> None:
    made = run('xacro', 'xacro', str(MACRO), 'height:=0.25').succeed()
    assert '<link name="forearm"/>' in made
    assert 'xyz="0 0 0.25"' in made


def test_without_the_package_one_is_told_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, 'xacro', None)
    assert main() == 1
    assert capsys.readouterr().err == f'{ADVICE}\n'
