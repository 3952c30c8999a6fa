"""Topics: rates, messages as they come, plots, pictures, and publishing."""

from __future__ import annotations

from time import monotonic
from typing import Any

from nicegui import ui

from goalwire.apps.console.page.charts import PALETTE, background, plot_line, plot_options, rest_while_still
from goalwire.apps.console.page.kept import keep_layout
from goalwire.apps.console.page.parts import LiveTable, ValueTree, forbid, head
from goalwire.apps.console.page.publish_form import PublishForm
from goalwire.apps.console.page.view import Page, View
from goalwire.apps.console.state.draft import Draft
from goalwire.apps.console.state.series import Series, as_csv, name_joint, number_at
from goalwire.apps.console.state.topics import Reading
from goalwire.errors import GoalwireError, RemoteError, UnknownInterfaceError, peer_text
from goalwire.idl.pictures import COMPRESSED, IMAGE, as_data_url
from goalwire.observe.clock import wall_offset
from goalwire.observe.messages import as_data
from goalwire.records import record

_SPANS = {10: '10 s', 30: '30 s', 60: '1 min', 300: '5 min'}
_MOST_SERIES = 16


@record
class Plotted:
    """A field that is plotted."""

    series: Series
    topic: str
    path: str
    reading: Reading


class TopicsView(View):
    """A list of topics on the left, the chosen one on the right, the plot below."""

    name = 'topics'
    title = 'Topics'
    icon = 'podcasts'
    period = 0.2

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._reading: Reading | None = None
        self._topic = ''
        self._type = ''
        self._filter = ''
        self._shown_at = 0.0
        self._tabled_at = 0.0
        self._plots: list[Plotted] = []
        self._paused_at: float | None = None
        self._span = page.layout.plot_span if page.layout.plot_span in _SPANS else 30
        self._awaited = [(topic, path) for topic, path in page.layout.plots]
        """The plots of the layout whose topics are not there yet."""
        self._publishing: PublishForm | None = None

    def build(self) -> None:
        self.session.topics.start_measuring()
        with ui.element('div').classes('gw-two'):
            with ui.element('div').classes('gw-card flush').style('max-height: 47vh'):
                with head('Topics', 'podcasts'):
                    ui.element('div').classes('gw-spread')
                    ui.input(placeholder='Filter', on_change=self._set_filter).props(
                        'outlined dense clearable data-filter'
                    ).style('width: 180px')
                self._table = LiveTable(
                    [
                        {'name': 'name', 'label': 'Topic', 'mono': True, 'clip': True},
                        {'name': 'type', 'label': 'Type', 'mono': True, 'clip': True},
                        {'name': 'rate', 'label': 'Rate', 'align': 'right', 'width': '84px'},
                    ],
                    empty='No topics yet.',
                    on_row=self.turning_to(self._choose),
                )
            with (
                ui.element('div').classes('gw-card').style('max-height: 47vh; overflow: auto') as self._detail
            ):
                ui.label('Choose a topic to see its messages.').classes('gw-empty')
        self._build_plot()

    def _build_plot(self) -> None:
        with ui.element('div').classes('gw-card gw-fill').style('min-height: 300px'):
            with head('Plot', 'show_chart'):
                self._names = ui.element('div').classes('gw-actions')
                ui.element('div').classes('gw-spread')
                ui.select(_SPANS, value=self._span, on_change=self._set_span).props(
                    'outlined dense options-dense'
                ).style('width: 92px')
                self._pause = ui.button('Pause', icon='pause', on_click=self._toggle_pause).props(
                    'flat dense no-caps data-pause'
                )
                ui.button('CSV', icon='download', on_click=self._save_csv).props(
                    'flat dense no-caps data-csv'
                )
                ui.button('PNG', icon='image', on_click=self._save_png).props('flat dense no-caps data-png')
            self._chart = ui.echart(plot_options(dark=self.page.is_dark)).classes('gw-fill')
            self._chart.style('width: 100%; min-height: 220px').props('data-plot')
            rest_while_still(self._chart)
        self._put_names()

    # -- the list --------------------------------------------------------------------------------------------

    def _set_filter(self, event: Any) -> None:
        self._filter = (event.value or '').lower()
        self._tabled_at = 0.0

    def refresh(self) -> None:
        now = monotonic()
        if now - self._tabled_at >= 1.0:
            self._tabled_at = now
            self._add_awaited()
            if not self._topic and self.page.layout.topic:
                self._choose(self.page.layout.topic)
            self._put_topics()
        if self._reading is not None:
            self._put_message(self._reading)
        elif self._type in self.session.types.described:  # a node has described the unknown type
            self._choose(self._topic)
        if self._paused_at is None and self._plots:
            self._put_plot(now)

    def _put_topics(self) -> None:
        rates = self.session.topics.rates
        rows = []
        for name, types in self.node.graph.topics():
            if self._filter not in f'{name} {types[0]}'.lower() or not self.rights.may_see('topic', name):
                continue
            rate = rates.get(name)
            text = '' if rate is None else f'{rate:.1f} Hz' if rate < 1000 else f'{rate / 1000:.1f} kHz'
            tone = {'tone': 'bad'} if len(types) > 1 else {}
            short = ', '.join(types).replace('/msg/', '/')
            cells = [
                {'text': name, 'title': name},
                {'text': short, 'title': ', '.join(types)},
                {'text': text, 'sort': rate or 0.0},
            ]
            rows.append({'key': name, 'cells': cells, **tone})
        self._table.put(rows)

    # -- one topic -------------------------------------------------------------------------------------------

    def _choose(self, name: str) -> None:
        types = dict(self.node.graph.topics()).get(name)
        if not types:
            return
        if self._reading is not None:
            self._reading.close()
            self._reading = None
        self._topic, self._type = name, types[0]
        if self.page.layout.topic != name:
            self.page.layout.topic = name
            keep_layout(self.page)
        self._table.choose(name)
        self._detail.clear()
        with self._detail:
            with ui.element('div').classes('gw-head'):
                ui.label(name).classes('gw-title gw-mono')
                ui.label(self._type).classes('gw-chip')
                ui.element('div').classes('gw-spread')
                self._info = ui.label('').classes('gw-dim gw-small')
                if self.settings.may_send(name):
                    publish = ui.button('Publish', icon='send', on_click=self._open_form).props(
                        'flat dense no-caps data-open-publish'
                    )
                    forbid(publish, self.rights.why_not_send('topic', name))
            self._picture = ui.image().classes('gw-picture').props('no-spinner no-transition fit=contain')
            self._picture.set_visibility(self._type in {IMAGE, COMPRESSED})
            self._tree = ValueTree(empty='No message has come yet.', on_plot=self._plot)
            self._publishing = PublishForm(self.page, name, self._type)
            try:
                self.rights.check_to_look('topic', name)
                self._reading = self.session.topics.read(name, self._type)
            except GoalwireError as error:
                ui.label(peer_text(error, 400)).classes('gw-problem')
        self._shown_at = 0.0
        self.page.refresh_soon()

    def _open_form(self) -> None:
        if self._publishing is not None:
            self._publishing.open()

    def _put_message(self, reading: Reading) -> None:
        reader = reading.reader
        if reader.latest is None or reader.latest_at == self._shown_at:
            return
        self._shown_at = reader.latest_at
        self._tree.put(as_data(reader.latest))
        rate = self.session.topics.rates.get(self._topic)
        self._info.set_text(f'{reader.count} messages' + ('' if rate is None else f', {rate:.1f} Hz'))
        if self._type in {IMAGE, COMPRESSED}:
            try:
                self._picture.set_source(as_data_url(reader.latest))
            except RemoteError as error:
                self._info.set_text(str(error))

    def resume(self, draft: Draft) -> bool:
        if self._topic != draft.name:
            self._choose(draft.name)
        if self._topic != draft.name or self._publishing is None:
            return False
        self._publishing.restore(draft)
        return True

    # -- the plot --------------------------------------------------------------------------------------------

    def _plot(self, path: str) -> None:
        if self._reading is not None:
            path = name_joint(path, self._reading.reader.latest)
        name = f'{self._topic} {path}'
        if len(self._plots) >= _MOST_SERIES or any(each.series.name == name for each in self._plots):
            return
        self._awaited = [each for each in self._awaited if each != (self._topic, path)]
        self._add_plot(self._topic, self._type, path)
        self._keep_plots()

    def _add_awaited(self) -> None:
        """Plot the numbers of the layout whose topics have come, if the visitor may see them."""
        there = dict(self.node.graph.topics())
        for topic, path in list(self._awaited):
            if topic not in there or len(self._plots) >= _MOST_SERIES:
                continue
            try:
                self.rights.check_to_look('topic', topic)
                self._add_plot(topic, there[topic][0], path)
            except UnknownInterfaceError:
                continue  # a node may describe the type later
            except GoalwireError as error:
                self.page.tell(peer_text(error, 400), 'warning')
            self._awaited.remove((topic, path))

    def _keep_plots(self) -> None:
        shown = [(each.topic, each.path) for each in self._plots]
        self.page.layout.plots = [list(each) for each in (*shown, *self._awaited)]
        keep_layout(self.page)

    def _add_plot(self, topic: str, type_name: str, path: str) -> None:
        plotted = self.page.plotted
        if (topic, path) not in plotted:
            plotted[topic, path] = Series(f'{topic} {path}')
        series, read = plotted[topic, path], number_at(path)

        def take(message: Any, at: float) -> None:
            value = read(message)
            if value is not None:
                series.append(at, value)

        reading = self.session.topics.read(topic, type_name, take)
        self._plots.append(Plotted(series, topic, path, reading))
        self._put_names()
        self.page.refresh_soon()

    def _put_names(self) -> None:
        self._names.clear()
        with self._names:
            if not self._plots:
                ui.label('Press ∿ beside a number of a message to plot it.').classes('gw-dim gw-small')
            for at, each in enumerate(self._plots):
                colour = PALETTE[at % len(PALETTE)]
                with ui.element('span').classes('gw-chip').props('data-series'):
                    ui.element('span').style(
                        f'width: 8px; height: 8px; border-radius: 4px; background: {colour}'
                    )
                    ui.label(each.series.name)
                    close = ui.icon('close', size='13px').style('cursor: pointer')
                    close.props['aria-label'] = f'Take {each.series.name} out of the plot'
                    close.on('click', lambda plotted=each: self._unplot(plotted))

    def _unplot(self, plotted: Plotted) -> None:
        plotted.reading.close()
        self._plots = [each for each in self._plots if each is not plotted]
        self.page.plotted.pop((plotted.topic, plotted.path), None)
        self._keep_plots()
        self._put_names()
        self._chart.run_chart_method('setOption', {'series': []}, {'replaceMerge': ['series']})

    def _put_plot(self, now: float) -> None:
        since, offset = now - self._span, wall_offset()
        series = [
            plot_line(
                each.series.name,
                at,
                [(round((t + offset) * 1000), v) for t, v in each.series.points(since)],
            )
            for at, each in enumerate(self._plots)
        ]
        bounds = {'min': round((since + offset) * 1000), 'max': round((now + offset) * 1000)}
        self._chart.run_chart_method(
            'setOption', {'xAxis': bounds, 'series': series}, {'replaceMerge': ['series'], 'lazyUpdate': True}
        )

    def _set_span(self, event: Any) -> None:
        self._span = self.page.layout.plot_span = int(event.value)
        keep_layout(self.page)
        if self._paused_at is not None:
            self._put_plot(self._paused_at)

    def _toggle_pause(self) -> None:
        self._paused_at = monotonic() if self._paused_at is None else None
        self._pause.set_text('Pause' if self._paused_at is None else 'Go on')
        self._pause.props(f'icon={"pause" if self._paused_at is None else "play_arrow"}')

    def _save_csv(self) -> None:
        if not self._plots:
            self.page.tell('Nothing is plotted: press ∿ beside a number.', 'info')
            return
        ui.download.content(
            as_csv([each.series for each in self._plots], wall_offset()), 'plot.csv', 'text/csv'
        )

    def _save_png(self) -> None:
        behind = background(dark=self.page.is_dark)
        ui.run_javascript(_png_script(self._chart.id, behind))

    def set_dark(self, dark: bool) -> None:
        self._chart.run_chart_method('setOption', plot_options(dark=dark))

    def close(self) -> None:
        self.session.topics.stop_measuring()
        if self._reading is not None:
            self._reading.close()
        for each in self._plots:
            each.reading.close()


def _png_script(chart: int, behind: str) -> str:
    """Return the script with which a browser saves a chart as a picture before a colour."""
    return f"""const a = document.createElement('a');
        a.href = getElement({chart}).chart.getDataURL({{pixelRatio: 2, backgroundColor: '{behind}'}});
        a.download = 'plot.png'; a.click();"""
