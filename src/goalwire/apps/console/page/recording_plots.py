"""Plots of numbers over the whole time of a recording."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from goalwire.apps.console.page.charts import PALETTE, plot_line, plot_options, rest_while_still
from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.recorded_plot import RecordedPlot
from goalwire.apps.console.state.recording import Recording

_MOST = 8
_CURSOR = 'cursor'


class RecordingPlots:
    """One chart, with a line at the page's position."""

    def __init__(self, recording: Recording, changed: Callable[[], object]) -> None:
        """`changed` is called when there is more to draw."""
        self._recording = recording
        self._changed = changed
        self._plots: list[RecordedPlot] = []
        self._sent: object = None
        self._cursor_sent = -1
        with ui.element('div').classes('gw-card').props('data-plots'):
            with head('Plot', 'show_chart'):
                self._names = ui.element('div').classes('gw-actions')
            self._chart = ui.echart(self._options(dark=False)).style('width: 100%; height: 230px')
            self._chart.props('data-plot')
            rest_while_still(self._chart)
        self._put_names()

    def _options(self, *, dark: bool) -> dict[str, Any]:
        options = plot_options(dark=dark)
        options['xAxis'] |= {'min': self._recording.start / 1e6, 'max': self._recording.end / 1e6}
        return options

    def add(self, topic: str, path: str) -> None:
        """Plot another number, unless it is plotted already or the chart is full."""
        name = f'{topic} {path}'
        if len(self._plots) < _MOST and all(plot.name != name for plot in self._plots):
            self._plots.append(RecordedPlot(self._recording, topic, path, self._changed))
            self._put_names()

    def _remove(self, plot: RecordedPlot) -> None:
        plot.close()
        self._plots.remove(plot)
        self._put_names()
        self._sent = None
        self._changed()

    def _put_names(self) -> None:
        self._names.clear()
        self._labels: list[Any] = []
        with self._names:
            if not self._plots:
                ui.label('Press ∿ beside a number of a message to plot it.').classes('gw-dim gw-small')
            for at, plot in enumerate(self._plots):
                with ui.element('span').classes('gw-chip').props('data-series'):
                    ui.element('span').style(
                        f'width: 8px; height: 8px; border-radius: 4px; background: {PALETTE[at]}'
                    )
                    self._labels.append(ui.label(plot.name))
                    ui.icon('close', size='13px').style('cursor: pointer').on(
                        'click', lambda plot=plot: self._remove(plot)
                    )

    def refresh(self, time: int) -> None:
        """Draw the values read so far, and the page's position, in ns."""
        state = [(plot.name, plot.part, len(plot.points)) for plot in self._plots]
        if state != self._sent:
            self._sent = state
            self._put_lines()
        if self._plots and time != self._cursor_sent:
            self._cursor_sent = time
            mark = {'id': _CURSOR, 'type': 'line', 'data': [], 'markLine': _mark_line(time)}
            self._chart.run_chart_method('setOption', {'series': [mark]}, {'lazyUpdate': True})

    def _put_lines(self) -> None:
        series = [
            plot_line(plot.name, at, [(round(time * 1000, 3), value) for time, value in plot.points])
            for at, plot in enumerate(self._plots)
        ]
        mark = {'id': _CURSOR, 'type': 'line', 'data': [], 'markLine': _mark_line(max(self._cursor_sent, 0))}
        self._chart.run_chart_method(
            'setOption', {'series': [*series, mark]}, {'replaceMerge': ['series'], 'lazyUpdate': True}
        )
        for label, plot in zip(self._labels, self._plots, strict=True):
            reading = f' {plot.part * 100:.0f} %' if plot.part < 1.0 else ''
            label.set_text(f'{plot.name}{reading}{": " + plot.problem if plot.problem else ""}')

    def set_dark(self, dark: bool) -> None:
        """Choose the colours."""
        options = self._options(dark=dark)
        del options['series']
        self._chart.run_chart_method('setOption', options)

    def close(self) -> None:
        """Stop reading the recording."""
        for plot in self._plots:
            plot.close()


def _mark_line(time: int) -> dict[str, Any]:
    return {
        'symbol': 'none',
        'silent': True,
        'animation': False,
        'label': {'show': False},
        'lineStyle': {'color': '#6366f1', 'width': 1.5, 'type': 'solid'},
        'data': [{'xAxis': time / 1e6}],
    }
