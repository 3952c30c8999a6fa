"""ros2 topic plot: fields of messages as curves in the terminal."""

from __future__ import annotations

import asyncio
import shutil
from argparse import ArgumentParser, Namespace
from collections import deque
from math import isfinite
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

import goalwire
from goalwire.apps.cli.commands.topic.reading import Source, source
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.fields import field_path, field_value
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.numbers import positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

SECONDS = 10.0
REPAINT_S = 0.1
_LEVELS = ' ▁▂▃▄▅▆▇█'
_LABEL = 11
"""Width of the numbers beside a curve, in columns."""
_ROWS = 8
"""The largest height of a curve, in lines of the terminal."""


class Curve(NamedTuple):
    """The values of one field over time."""

    title: str
    topic: Source
    path: list[str | int]
    points: deque[tuple[float, float]]


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic plot`."""
    parser.add_argument(
        'fields', nargs='+', metavar='NAME.FIELD', help="What to draw (e.g. '/odom.pose.pose.position.x')"
    )
    add_graph_arguments(parser)
    parser.add_argument(
        '--seconds',
        metavar='S',
        type=positive,
        default=SECONDS,
        help=f'How far back to draw (default: {SECONDS:.0f})',
    )


def curve_text(
    points: list[tuple[float, float]], start: float, end: float, columns: int, rows: int
) -> list[str]:
    """Return the lines that draw a curve between two times, with its extreme values beside it.

    If several points fall into one column, the latest is drawn.
    """
    width = max(1, columns - _LABEL - 1)
    shown = [(at, value) for at, value in points if start <= at <= end]
    if not shown:
        return [' ' * _LABEL + '│'] * rows
    low, high = min(value for _, value in shown), max(value for _, value in shown)
    span = high - low or 1.0
    column: dict[int, int] = {}
    for at, value in shown:
        place = min(width - 1, int((at - start) / (end - start) * width))
        column[place] = 1 + round((value - low) / span * (rows * 8 - 1))
    lines = []
    for row in range(rows - 1, -1, -1):
        label = f'{high:.4g}' if row == rows - 1 else f'{low:.4g}' if row == 0 else ''
        cells = (_LEVELS[max(0, min(8, column.get(place, 0) - row * 8))] for place in range(width))
        lines.append(f'{label:>{_LABEL}}│{"".join(cells)}'.rstrip())
    return lines


class _Plot:
    """The curves, redrawn in place."""

    def __init__(self, curves: list[Curve], seconds: float, output: Output) -> None:
        self._curves = curves
        self._seconds = seconds
        self._output = output
        self._painted = 0

    def paint(self) -> None:
        columns, height = shutil.get_terminal_size()
        rows = max(1, min(_ROWS, (height - 1) // len(self._curves) - 1))
        now, lines = monotonic(), list[str]()
        for curve in self._curves:
            latest = f'{curve.points[-1][1]:.6g}' if curve.points else 'nothing has come yet'
            lines.append(self._output.style(f'{curve.title}: {latest}'[: columns - 1], 'bold'))
            lines += curve_text(list(curve.points), now - self._seconds, now, columns - 1, rows)
        back = f'\x1b[{self._painted}A' if self._painted else ''
        self._output.raw(back + ''.join(f'\r{line}\x1b[K\n' for line in lines) + '\x1b[J')
        self._painted = len(lines)


def _curve(arguments: Namespace, given: str) -> Curve:
    name, dot, field = given.partition('.')
    if not dot or not field:
        raise CommandError(
            Outcome.USAGE, f"'{given}' names no field", "write it like '/odom.pose.pose.position.x'"
        )
    path = field_path(field)
    topic = source(arguments, name)
    # report an unknown field now, before any message comes
    field_value(topic.cls(), [step for step in path if isinstance(step, str)][:1], field)
    return Curve(f'{topic.name}.{field}', topic, path, deque(maxlen=10_000))


async def _follow(node: goalwire.Node, curve: Curve) -> None:
    async for message in node.subscription(curve.topic.cls, curve.topic.name, qos=curve.topic.qos):
        value: Any = field_value(message, curve.path, curve.title)
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise CommandError(
                Outcome.BAD_VALUE, f"'{curve.title}' is not a number", 'name a field that is one'
            ) from None
        if isfinite(number):
            curve.points.append((monotonic(), number))


def run(arguments: Namespace, output: Output) -> Outcome:
    """Draw until Ctrl-C; raises CommandError with `--json` or without a terminal."""
    if not output.is_terminal:
        raise CommandError(
            Outcome.UNAVAILABLE,
            'topic plot needs a terminal that it can draw on',
            'use: ros2 topic echo --field',
        )
    curves = [_curve(arguments, each) for each in arguments.fields]
    plot = _Plot(curves, arguments.seconds, output)

    async def draw(node: goalwire.Node) -> None:
        async with asyncio.TaskGroup() as group:
            for curve in curves:
                group.create_task(_follow(node, curve))
            while True:
                plot.paint()
                await asyncio.sleep(REPAINT_S)

    return live(draw, use_sim_time=arguments.use_sim_time)
