"""Every reader of what others have written accepts it, or refuses it with its one documented error."""

from __future__ import annotations

import pytest
from fuzz.targets import TARGETS, Target
from hypothesis import given, settings
from hypothesis import strategies as st

EACH = pytest.mark.parametrize('target', TARGETS, ids=lambda target: target.name)


@st.composite
def damaged(draw: st.DrawFn, seeds: tuple[bytes, ...]) -> bytes:
    """Draw one of the seeds with a few cuts, insertions, repetitions and changed bytes."""
    data = draw(st.sampled_from(seeds))
    for _ in range(draw(st.integers(1, 4))):
        start, end = sorted((draw(st.integers(0, len(data))), draw(st.integers(0, len(data)))))
        part = draw(
            st.one_of(
                st.just(b''),
                st.binary(max_size=8),
                st.sampled_from(
                    [
                        b'SLOT_TYPES',
                        b' nan',
                        b'\xff\xff\xff\xff',
                        b'\xff',
                        b'\0',
                        b'/',
                        b'..',
                        b'[',
                        b'<=',
                        b'9' * 30,
                        b'9' * 5000,
                        b'**/',
                    ]
                ),
                st.just(data[start:end] * 2),
            )
        )
        data = data[:start] + part + data[min(end, start + draw(st.integers(0, 8))) :]
    return data


@EACH
def test_what_is_well_formed_is_accepted(target: Target) -> None:
    for seed in target.seeds:
        assert target(seed)


@EACH
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_what_is_damaged_is_accepted_or_refused_as_documented(target: Target, data: st.DataObject) -> None:
    target(data.draw(damaged(target.seeds)))


@EACH
@settings(max_examples=30, deadline=None)
@given(noise=st.binary(max_size=200))
def test_noise_is_accepted_or_refused_as_documented(target: Target, noise: bytes) -> None:
    target(noise)
