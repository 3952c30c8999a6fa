"""Captured traffic of eclipse-zenoh, batch by batch."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

DATA = Path(__file__).parents[1] / 'data' / 'zenoh'


class Batch(NamedTuple):
    """One batch, without its length."""

    sender: str
    says: str
    data: bytes

    @property
    def sent(self) -> bytes:
        return len(self.data).to_bytes(2, 'little') + self.data


def conversation(name: str = 'conversation.txt') -> list[Batch]:
    """Return the batches of a file: lines that name the sender and what it says, and indented hex below."""
    batches: list[Batch] = []
    for line in (DATA / name).read_text().splitlines():
        if line.startswith('#') or not line.strip():
            continue
        if line.startswith(' '):
            last = batches.pop()
            batches.append(last._replace(data=last.data + bytes.fromhex(line.strip())))
        else:
            sender, _, says = line.partition(' ')
            batches.append(Batch(sender, says, b''))
    return batches
