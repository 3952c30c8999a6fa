"""Plots as SVG, written by hand: points on logarithmic axes, readable on light and dark pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import ceil, floor, log10
from typing import NamedTuple, TypeAlias
from xml.sax.saxutils import escape

COLOURS = ('#1f77b4', '#d62728', '#2ca02c', '#9467bd', '#8c564b', '#e377c2', '#7f7f7f')
GREY = '#888'
Points: TypeAlias = Sequence[tuple[float, float]]


class Axis(NamedTuple):
    """A logarithmic axis from `low` to `high`, drawn from pixel `start` to pixel `end`."""

    title: str
    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """Return the pixel of a value."""
        share = (log10(value) - log10(self.low)) / (log10(self.high) - log10(self.low))
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """Return the powers of ten within, and where these are few, 2 and 5 times them."""
        steps = (1,) if self.high / self.low > 2000 else (1, 2, 5)
        powers = range(floor(log10(self.low)), ceil(log10(self.high)) + 1)
        ticks = [step * 10.0**power for power in powers for step in steps]
        return [tick for tick in ticks if self.low <= tick * 1.0001 and tick <= self.high * 1.0001]


def around(title: str, values: Iterable[float], start: float, end: float) -> Axis:
    """Return an axis with room for the values."""
    known = [value for value in values if value > 0] or [1.0]
    low, high = min(known), max(known)
    return Axis(title, low / 1.25, high * 1.25, start, end)


def text(x: float, y: float, words: str, *, anchor: str = 'start', colour: str = GREY, turn: int = 0) -> str:
    """Return a text."""
    turned = f' transform="rotate({turn} {x:.1f} {y:.1f})"' if turn else ''
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}"{turned}>{escape(words)}</text>'
    )


def line(x1: float, y1: float, x2: float, y2: float, *, colour: str = GREY, opacity: float = 0.3) -> str:
    """Return a straight line."""
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" '
        f'stroke="{colour}" stroke-opacity="{opacity}"/>'
    )


def dot(x: float, y: float, colour: str, words: str) -> str:
    """Return a point that tells its value where the pointer rests on it."""
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"><title>{escape(words)}</title></circle>'


def legend(names: Iterable[str], x: float, y: float) -> list[str]:
    """Return the names, each with its colour, one below the other."""
    parts = []
    for index, (name, colour) in enumerate(zip(names, COLOURS, strict=False)):
        parts += [dot(x, y + 16 * index - 4, colour, name), text(x + 10, y + 16 * index, name)]
    return parts


def page(width: int, height: int, parts: Iterable[str]) -> str:
    """Return the whole file."""
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="11">'
    )
    return '\n'.join([head, *parts, '</svg>', ''])


def curves(title: str, x_title: str, y_title: str, series: Mapping[str, Points]) -> str:
    """Return a plot of lines through points, both axes logarithmic."""
    width, height = 720, 360
    points = [point for line_ in series.values() for point in line_]
    x = around(x_title, [point[0] for point in points], 60, width - 190)
    y = around(y_title, [point[1] for point in points], height - 45, 30)
    parts = [text(x.start, 16, title, colour='#555')]
    for tick in x.ticks():
        parts += [line(x.at(tick), y.start, x.at(tick), y.end)]
        parts += [text(x.at(tick), y.start + 15, short(tick), anchor='middle')]
    for tick in y.ticks():
        parts += [line(x.start, y.at(tick), x.end, y.at(tick))]
        parts += [text(x.start - 6, y.at(tick) + 4, short(tick), anchor='end')]
    parts += [text((x.start + x.end) / 2, height - 8, x_title, anchor='middle')]
    parts += [text(14, (y.start + y.end) / 2, y_title, anchor='middle', turn=-90)]
    for (name, line_), colour in zip(series.items(), COLOURS, strict=False):
        path = ' '.join(f'{x.at(a):.1f},{y.at(b):.1f}' for a, b in line_)
        parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        parts += [dot(x.at(a), y.at(b), colour, f'{name}: {short(a)}, {short(b)}') for a, b in line_]
    return page(width, height, [*parts, *legend(series, x.end + 20, 45)])


def rows(title: str, x_title: str, table: Mapping[str, Mapping[str, float]]) -> str:
    """Return a plot of one row a work, with a point for everybody who did it, on one logarithmic axis."""
    names = list(dict.fromkeys(name for row in table.values() for name in row))
    width, top, step = 900, 60, 26
    height = top + step * len(table) + 50
    x = around(x_title, [value for row in table.values() for value in row.values()], 330, width - 170)
    bottom = top + step * len(table) - step / 2
    parts = [text(10, 20, title, colour='#555')]
    for tick in x.ticks():
        parts += [line(x.at(tick), top - step / 2, x.at(tick), bottom, opacity=0.7 if tick == 1 else 0.2)]
        parts += [text(x.at(tick), bottom + 15, short(tick), anchor='middle')]
    parts += [text((x.start + x.end) / 2, bottom + 34, x_title, anchor='middle')]
    for index, (work, row) in enumerate(table.items()):
        height_ = top + step * index
        parts += [text(x.start - 8, height_ + 4, work, anchor='end')]
        parts += [line(x.start, height_, x.end, height_, opacity=0.15)]
        parts += [
            dot(x.at(value), height_, COLOURS[names.index(name) % len(COLOURS)], f'{name}: {value:.3g}')
            for name, value in row.items()
            if value > 0
        ]
    return page(width, height, [*parts, *legend(names, x.end + 20, top)])


def bars(title: str, x_title: str, table: Mapping[str, Mapping[str, float]]) -> str:
    """Return a plot of one group of bars a work, a bar for each who has a value, from 0 up."""
    names = list(dict.fromkeys(name for row in table.values() for name in row))
    width, top, thick = 900, 50, 9
    start, end = 330, width - 170
    highest = max(value for row in table.values() for value in row.values())
    scale = (end - start) / highest / 1.1
    parts, y = [text(10, 20, title, colour='#555')], top
    for work, row in table.items():
        parts += [text(start - 8, y + thick * len(names) / 2 + 4, work, anchor='end')]
        for index, name in enumerate(names):
            if name in row:
                parts += [_bar(start, y + thick * index, row[name] * scale, COLOURS[index])]
                shown = short(row[name])
                parts += [text(start + row[name] * scale + 5, y + thick * (index + 1) - 1, shown)]
        y += thick * len(names) + 12
    parts += [line(start, top - 6, start, y - 6, opacity=0.7)]
    parts += [text((start + end) / 2, y + 12, x_title, anchor='middle')]
    return page(width, y + 24, [*parts, *legend(names, end + 20, top)])


def _bar(x: float, y: float, length: float, colour: str) -> str:
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{length:.1f}" height="8" fill="{colour}"/>'


def short(value: float) -> str:
    """Return a number as a tick shows it."""
    for size, letter in ((1e6, 'M'), (1e3, 'k')):
        if value >= size:
            return f'{value / size:.3g}{letter}'
    return f'{value:.3g}'
