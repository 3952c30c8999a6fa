from __future__ import annotations

import pytest

from humanoid.mission.events import Began, Event, Finished, Progressed, Retrying, from_line, to_line


@pytest.mark.parametrize(
    'event',
    [
        Began(1, 3, 'drive', 'SUCCEEDED'),
        Progressed(1, 0.5, 'half-way: "über"\n'),
        Retrying(2, 1, 0.2, 'no server'),
        Finished(3, ok=False, happened='ABORTED', seconds=1.5),
    ],
)
def test_an_event_survives_its_line(event: Event) -> None:
    line = to_line(event)
    assert '\n' not in line
    assert from_line(line) == event


@pytest.mark.parametrize('line', ['', '[INFO] Goal accepted', '{"event": "Began"}'])
def test_other_output_is_no_event(line: str) -> None:
    assert from_line(line) is None
