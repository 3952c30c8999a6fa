"""The messages that a real ROS 2 Jazzy sent over Cyclone DDS."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import pytest
from helpers.captured import Captured

CAPTURED = Path(__file__).parents[2] / 'data' / 'dds' / 'captured.jsonl'


@pytest.fixture(scope='session')
def captured() -> list[Captured]:
    """Every captured message."""
    lines: list[Mapping[str, str]] = [json.loads(line) for line in CAPTURED.read_text().splitlines()]
    return [
        Captured(line['what'], line['topic'], bytes.fromhex(line['hex']), line['meaning']) for line in lines
    ]
