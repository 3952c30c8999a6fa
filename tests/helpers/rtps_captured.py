"""Packets that real implementations of RTPS have sent: Fast DDS 2.14 and 3.2, Cyclone DDS 11."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parents[1] / 'data' / 'rtps'


class Packet(NamedTuple):
    """One UDP packet, and who sent it for what."""

    scenario: str
    sender: str
    what: str
    topic: str | None
    data: bytes


def packets() -> Iterator[Packet]:
    """Yield every captured packet."""
    for file in sorted(FOLDER.glob('*.jsonl')):
        for line in file.read_text(encoding='utf-8').splitlines():
            entry = json.loads(line)
            data = bytes.fromhex(entry['hex'])
            yield Packet(file.stem, entry['from'], entry['what'], entry.get('topic'), data)
