"""CI's short form: what counts as slower, and that every ratio has its expectation."""

from __future__ import annotations

import json

from benchmarks.short import BAND, EXPECTED, PAIRS, slowed


def test_only_what_leaves_the_band_is_slower() -> None:
    expected = {'call': 2.0, 'topic': 1.0}
    assert slowed({'call': 2.0 * BAND, 'topic': 0.1}, expected) == []
    assert slowed({'call': 2.0 * BAND + 0.1, 'topic': 1.0}, expected) == ['call']


def test_every_ratio_to_a_raw_wire_has_an_expectation() -> None:
    assert {pair.name for pair in PAIRS} < json.loads(EXPECTED.read_text(encoding='utf-8')).keys()
