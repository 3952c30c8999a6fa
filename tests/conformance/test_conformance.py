"""Plain rclpy programs see under goalwire what they see under the real rclpy, or what is listed."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.markdown import DOCS
from helpers.traces import Difference, Differences, ForeignText, Trace

FOLDER = Path(__file__).parent
PROGRAMS = sorted(file.stem for file in (FOLDER / 'programs').glob('*.py'))
DIFFERENCES = Differences(FOLDER / 'differences.toml')
PAGE = (DOCS / 'reference' / 'differences-from-rclpy.md').read_text(encoding='utf-8')


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize('program', PROGRAMS)
def test_a_program_sees_what_it_sees_under_the_real_rclpy(program: str, trace: Trace) -> None:
    ours, real = trace(program)
    assert real
    found = list(DIFFERENCES.complaints(program, ours, real))
    assert not found, '\n'.join([f'{len(found)} of {len(real)} calls differ:', *found])


@pytest.mark.parametrize(
    'listed', [*DIFFERENCES.listed, *DIFFERENCES.foreign_texts], ids=lambda listed: listed.docs
)
def test_the_docs_argue_for_every_difference(listed: Difference | ForeignText) -> None:
    assert listed.docs in PAGE


@pytest.mark.parametrize('difference', DIFFERENCES.listed, ids=lambda difference: difference.docs)
def test_a_program_meets_every_difference(difference: Difference) -> None:
    names = [difference.program] if difference.program else PROGRAMS
    sources = [(FOLDER / 'programs' / f'{name}.py').read_text(encoding='utf-8') for name in names]
    for call in difference.calls:
        assert any(call in source for source in sources), f'no program calls {call}'
