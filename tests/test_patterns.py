"""Regular expressions that are compiled at their first use."""

from __future__ import annotations

import re
import subprocess
import sys
from textwrap import dedent

import pytest

from goalwire.patterns import Pattern


def test_a_pattern_has_the_methods_of_a_regular_expression() -> None:
    letters = Pattern('[A-Z]', re.IGNORECASE)
    found = letters.search('12ab')
    assert found is not None
    assert found[0] == 'a'
    assert letters.fullmatch('ab') is None
    assert letters.match('1') is None
    assert letters.sub('-', '1a2b') == '1-2-'
    assert letters.findall('1a2b') == ['a', 'b']
    assert [each.start() for each in letters.finditer('1a2b')] == [1, 3]


def test_a_pattern_has_no_other_attributes() -> None:
    with pytest.raises(AttributeError, match='splitting'):
        _ = Pattern('a').splitting


def test_nothing_is_compiled_by_the_import_of_rclpy() -> None:
    program = """
        import re

        compiled, compile_ = [], re.compile
        re.compile = lambda text, flags=0: compiled.append(text) or compile_(text, flags)
        import rclpy.node

        print(compiled)
    """
    command = [sys.executable, '-c', dedent(program)]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert result.stdout.strip() == '[]'
