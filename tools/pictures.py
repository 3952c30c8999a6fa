"""Draws the pictures of docs/reference/{performance,reliability}.md from the tables there.

python -m tools.pictures     write them; a test compares them with the tables
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from benchmarks import svg

DOCS = Path(__file__).resolve().parents[1] / 'docs'
REFERENCE = DOCS / 'reference'
SPEED, FAILING = REFERENCE / 'performance' / 'summary.svg', REFERENCE / 'reliability' / 'time-to-error.svg'
PEER = 'rclpy beside'
WORK = {
    'service call, `call_async` + `spin_until_future_complete`': 'service call',
    'service call, blocking `call`, a thread spins': 'blocking service call',
    '32 calls in flight, calls/s; lost': '32 calls in flight, time of one',
    'topic there and back, callbacks both sides': 'topic there and back',
    'PoseStamped to a callback, messages/s': 'message to a callback, time of one',
    'action, goal to result, after 200 goals': 'action, goal to result',
    'feedback, messages/s; share that came': 'feedback, time of one',
    '1 kHz timer, CPU a tick': 'timer, CPU of a tick',
    'import, node, discovery, first call, ms': 'from start to the first answer',
    'memory of that client, MB': 'memory',
}
"""The rows of the page that are drawn, and what they are called in the picture."""
FAULTS = {
    '1: the server vanishes mid-feedback': 'the server vanishes during a goal',
    '1: SIGKILL of the server mid-feedback': 'the server is killed (DDS: lease 1 s)',
    '1: the server neither ends its goals nor lets them be cancelled': 'the goal never ends; deadline 0.1 s',
    '9: a cable cut for 1 s, both ways': 'the cable is cut; deadline 0.25 s',
    '9: SIGSTOP of the server, for longer than its lease, then SIGCONT': 'the server is stopped; lease 1 s',
    '13: two bytes flipped in each request and reply': 'bytes flipped on the way',
    '16: shutdown under four that wait, on a wire that loses everything': 'shutdown under four that wait',
    '17: the clock is set back by an hour while a call waits': 'the clock is set back; deadline 0.3 s',
}
Table = dict[str, dict[str, str]]


def table(page: Path, first: str) -> Table:
    """Return the table of a page whose first heading is `first`: a row by its name, a cell by its heading."""
    text = page.read_text(encoding='utf-8')
    head, _, *lines = text[text.index(f'| {first} |') :].split('\n\n')[0].strip().splitlines()
    names = _cells(head)
    return {cells[0]: dict(zip(names, cells, strict=True)) for cells in map(_cells, lines)}


def _cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip().strip('|').split('|')]


def _number(cell: str) -> float:
    """The first number of a cell; 0 if there is none."""
    found = re.search(r'[\d,]+(\.\d+)?', cell)
    return float(found[0].replace(',', '')) if found else 0.0


def speed() -> str:
    """Return the picture of how long things take, as multiples of the real rclpy."""
    page = table(REFERENCE / 'performance.md', 'work')
    drawn: dict[str, Mapping[str, float]] = {}
    for work, label in WORK.items():
        base = _number(page[work][PEER])
        ratios = {who: _number(page[work][who]) / base for who in ('Zenoh', 'DDS', PEER)}
        is_rate = '/s' in work
        drawn[label] = {who: 1 / ratio if is_rate else ratio for who, ratio in ratios.items()}
    return svg.rows(
        'Less is better: 0.1 is a tenth of what the real rclpy takes', f'multiple of {PEER}', drawn
    )


def failing() -> str:
    """Return the picture of the longest time from a fault to the error that tells of it."""
    page = table(REFERENCE / 'reliability.md', 'item and fault')
    drawn: dict[str, dict[str, float]] = {label: {} for label in FAULTS.values()}
    for fault, label in FAULTS.items():
        for wire in ('Zenoh', 'DDS'):
            if found := re.search(r'; ([\d.]+) s$', page[fault][wire]):
                drawn[label][wire] = float(found[1])
    return svg.bars('The longest time from a fault to the error that tells of it', 's', drawn)


def main() -> None:
    """Write both."""
    for file, draw in ((SPEED, speed), (FAILING, failing)):
        file.parent.mkdir(exist_ok=True)
        file.write_text(draw(), encoding='utf-8')


if __name__ == '__main__':
    main()
