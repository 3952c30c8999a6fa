"""The page of the command line has every verb and flag; what Jazzy has besides is listed with a reason."""

from __future__ import annotations

import sys
from importlib import util
from types import ModuleType

import pytest
from helpers.markdown import DOCS, ROOT


@pytest.fixture(scope='module')
def tool() -> ModuleType:
    spec = util.spec_from_file_location('command_line_table', ROOT / 'tools' / 'command_line_table.py')
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_what_jazzy_has_and_goalwire_has_not_is_listed_with_a_reason(tool: ModuleType) -> None:
    assert sorted(tool.missing()) == sorted(tool.MISSING)


def test_the_page_is_what_the_parsers_say(tool: ModuleType) -> None:
    text = (DOCS / 'reference' / 'command-line.md').read_text(encoding='utf-8')
    assert text == tool.page(), 'run: python tools/command_line_table.py'
