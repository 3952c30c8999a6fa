"""The options of the page's charts, in the format of ECharts, and their common colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import ui

from goalwire.apps.console.page.view import duration

PALETTE = ('#6366f1', '#10b981', '#f59e0b', '#ef4444', '#06b6d4', '#a855f7', '#84cc16', '#ec4899')
"""The colours of the lines of a plot."""
_BAD = '#ef4444'
_COLOURS = {'node': '#6366f1', 'topic': '#94a3b8', 'service': '#14b8a6', 'action': '#f59e0b'}
_SHAPES = {'node': 'circle', 'topic': 'roundRect', 'service': 'diamond', 'action': 'triangle'}


def _text_and_line(*, dark: bool) -> tuple[str, str]:
    """Return the colours of a chart's texts and lines."""
    return ('#93a1b8', '#243146') if dark else ('#64748b', '#e2e8f0')


def background(*, dark: bool) -> str:
    """Return the colour behind a chart that is saved as a picture."""
    return '#131c2b' if dark else '#ffffff'


def rest_while_still(chart: ui.echart) -> None:
    """Have a chart ask the browser for two frames more after a drawing, not for ten, as ECharts would."""
    chart.on('chart:rendered', js_handler=f'() => getElement({chart.id}).chart.getZr().setSleepAfterStill(1)')


def plot_options(*, dark: bool) -> dict[str, Any]:
    """Return the options of a plot over time, without lines."""
    text, line = _text_and_line(dark=dark)
    axis = {'axisLabel': {'color': text, 'fontSize': 11}, 'axisLine': {'lineStyle': {'color': line}}}
    return {
        'animation': False,
        'backgroundColor': 'transparent',
        'grid': {'left': 12, 'right': 18, 'top': 12, 'bottom': 8, 'containLabel': True},
        'tooltip': {'trigger': 'axis', 'renderMode': 'richText'},
        'xAxis': {'type': 'time', 'splitLine': {'show': False}, **axis},
        'yAxis': {'type': 'value', 'scale': True, 'splitLine': {'lineStyle': {'color': line}}, **axis},
        'series': [],
    }


def plot_line(name: str, number: int, points: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return one line of a plot: its points are times in ms since 1970, and values."""
    return {
        'id': name,
        'name': name,
        'type': 'line',
        'showSymbol': False,
        'lineStyle': {'width': 1.8},
        'color': PALETTE[number % len(PALETTE)],
        'data': points,
    }


def histogram_options(bins: list[tuple[float, int]], *, dark: bool) -> dict[str, Any]:
    """Return the options of a histogram of times: upper limits in s, and how many lie below each."""
    text, line = _text_and_line(dark=dark)
    return {
        'animation': False,
        'grid': {'left': 8, 'right': 8, 'top': 10, 'bottom': 4, 'containLabel': True},
        'tooltip': {'renderMode': 'richText'},
        'xAxis': {
            'type': 'category',
            'data': [f'< {duration(upper)}' for upper, _ in bins],
            'axisLabel': {'color': text, 'fontSize': 10},
            'axisLine': {'lineStyle': {'color': line}},
        },
        'yAxis': {
            'type': 'value',
            'minInterval': 1,
            'axisLabel': {'color': text, 'fontSize': 10},
            'splitLine': {'lineStyle': {'color': line}},
        },
        'series': [
            {
                'type': 'bar',
                'data': [number for _, number in bins],
                'color': '#6366f1',
                'barCategoryGap': '12%',
                'itemStyle': {'borderRadius': [3, 3, 0, 0]},
            }
        ],
    }


def graph_point(key: str, name: str, kind: str, *, dark: bool) -> dict[str, Any]:
    """Return a point of the graph: a node, topic, service or action."""
    return {
        'id': key,
        'name': name,
        'category': kind,
        'symbol': _SHAPES[kind],
        'symbolSize': 22 if kind == 'node' else 13,
        'itemStyle': {'color': _COLOURS[kind]},
        'label': {
            'fontWeight': 600 if kind == 'node' else 400,
            'color': ('#e6ebf4' if dark else '#0f172a')
            if kind == 'node'
            else ('#93a1b8' if dark else '#64748b'),
        },
    }


def graph_options(points: list[dict[str, Any]], links: list[dict[str, Any]], *, dark: bool) -> dict[str, Any]:
    """Return the options of the graph's drawing."""
    text, _ = _text_and_line(dark=dark)
    return {
        'animation': False,
        'backgroundColor': 'transparent',
        'tooltip': {'renderMode': 'richText'},
        'legend': [
            {
                'data': [
                    {'name': kind, 'icon': _SHAPES[kind], 'itemStyle': {'color': _COLOURS[kind]}}
                    for kind in _COLOURS
                ],
                'top': 0,
                'left': 0,
                'textStyle': {'color': text},
                'itemWidth': 12,
                'itemHeight': 12,
            }
        ],
        # Axes, as a graph's own coordinates would stretch its symbols together with the drawing.
        'grid': {'left': 60, 'right': 60, 'top': 44, 'bottom': 34},
        'xAxis': {'show': False, 'min': 'dataMin', 'max': 'dataMax'},
        'yAxis': {'show': False, 'min': 'dataMin', 'max': 'dataMax', 'inverse': True},
        'dataZoom': [
            {'type': 'inside', 'xAxisIndex': 0, 'filterMode': 'none'},
            {'type': 'inside', 'yAxisIndex': 0, 'filterMode': 'none'},
        ],
        'series': [
            {
                'type': 'graph',
                'coordinateSystem': 'cartesian2d',
                'labelLayout': {'hideOverlap': True},
                'label': {
                    'show': True,
                    'position': 'bottom',
                    'fontSize': 11,
                    'formatter': '{b}',
                    'textMargin': [2, 4],
                },
                'edgeSymbol': ['none', 'arrow'],
                'edgeSymbolSize': 6,
                'lineStyle': {'color': '#475569' if dark else '#94a3b8', 'width': 1.2, 'curveness': 0.06},
                'emphasis': {'focus': 'adjacency'},
                'categories': [{'name': kind} for kind in _COLOURS],
                'data': points,
                'links': links,
            }
        ],
    }


def mark_as_bad(point: dict[str, Any], link: dict[str, Any]) -> None:
    """Draw a point and a link of the graph as a mismatch."""
    link['lineStyle'] = {'color': _BAD, 'width': 2.5}
    point['itemStyle'] = {'color': _BAD}
