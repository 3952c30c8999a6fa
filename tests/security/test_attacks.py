"""Each attempt on a protected robot ends as the policy says; `attacks.py` prints a table of all of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from goalwire.security.policy import Verb

from .attacks import ATTEMPTS, STRANGE, WAYS, Way, try_as_mallory, try_as_stranger


def test_every_verb_is_tried() -> None:
    assert set(ATTEMPTS) == set(Verb)


@pytest.mark.slow
@pytest.mark.parametrize('way', WAYS[1::2], ids=[way.title for way in WAYS[1::2]])
def test_a_stock_session_does_what_its_policy_says(tmp_path: Path, way: Way) -> None:
    ended = try_as_mallory(tmp_path, way, seed=0)
    assert {each.should for each in ended} == {True, False}
    assert [each for each in ended if each.succeeded is not each.should] == []


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize('way', WAYS, ids=[way.title for way in WAYS])
@pytest.mark.parametrize('seed', range(10))
def test_whoever_has_rights_can_do_that_and_no_more(tmp_path: Path, way: Way, seed: int) -> None:
    ended = try_as_mallory(tmp_path, way, seed)
    assert [each for each in ended if each.succeeded is not each.should] == []


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(('who', 'way'), STRANGE, ids=[f'{who}, {way.title}' for who, way in STRANGE])
def test_a_stranger_can_do_nothing(tmp_path: Path, who: str, way: Way) -> None:
    assert [each.verb for each in try_as_stranger(tmp_path, way, who) if each.succeeded] == []
