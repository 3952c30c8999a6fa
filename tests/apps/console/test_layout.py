"""A page's layout as a text: what is taken, and what is refused."""

from __future__ import annotations

import json
from typing import Any

import pytest

from goalwire.apps.console.state.layout import MOST_BYTES, Layout


def text_of(**values: Any) -> str:
    return json.dumps({'goalwire_layout': 1, **values})


def test_a_layout_is_the_same_after_it_was_a_text() -> None:
    layout = Layout()
    layout.view, layout.follows, layout.camera = 'robot', False, [1.0, 2.0, 3.0, 0.0, 0.0, 0.5]
    layout.layers, layout.plots, layout.plot_span = {'/map': False}, [['/load', 'data']], 60
    other = Layout()
    other.take(layout.as_json())
    assert vars(other) == vars(layout)


def test_values_that_a_text_lacks_become_the_standard_ones() -> None:
    layout = Layout()
    layout.axes = True
    layout.take(text_of(topic='/load', of_a_newer_console=[1]))
    assert (layout.axes, layout.topic) == (False, '/load')


@pytest.mark.parametrize(
    ('text', 'why'),
    [
        ('', 'not JSON'),
        ('[' * 100_000, 'not JSON'),
        ('[]', "'goalwire_layout' should be 1"),
        ('{"goalwire_layout": 2}', "'goalwire_layout' should be 1"),
        (' ' * (MOST_BYTES + 1), 'this text is larger'),
        (text_of(view=3), "'view'"),
        (text_of(axes=1), "'axes'"),
        (text_of(camera=[1, 2]), "'camera'"),
        (text_of(camera=[1, 2, 3, 4, 5, float('nan')]), "'camera'"),
        (text_of(camera=[1, 2, 3, 4, 5, 10**400]), "'camera'"),
        (text_of(layers={'/map': 'yes'}), "'layers'"),
        (text_of(plots=[['/load']]), "'plots'"),
        (text_of(plots=[['/load', 'x' * 500]]), "'plots'"),
        (text_of(hidden_frames=[1]), "'hidden_frames'"),
        (text_of(hidden_frames=['x'] * 3000), "'hidden_frames'"),
        (text_of(plot_span=0), "'plot_span'"),
    ],
)
def test_another_text_is_refused_and_changes_nothing(text: str, why: str) -> None:
    layout = Layout()
    layout.topic = '/load'
    with pytest.raises(ValueError, match=why):
        layout.take(text)
    assert layout.topic == '/load'
