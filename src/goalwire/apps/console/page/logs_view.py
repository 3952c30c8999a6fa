"""Logs: /rosout of all nodes, with filters."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from goalwire.apps.console.page.parts import LiveTable, head
from goalwire.apps.console.page.view import Page, View
from goalwire.observe.clock import local_time
from goalwire.observe.log import LEVELS, LogLine
from goalwire.security.policy import Verb

_SHOWN = 300
_TONES = {'DEBUG': '', 'INFO': 'info', 'WARN': 'warn', 'ERROR': 'bad', 'FATAL': 'bad'}
COLUMNS = (
    {'name': 'at', 'label': 'Time', 'mono': True, 'width': '108px'},
    {'name': 'level', 'label': 'Level', 'width': '84px'},
    {'name': 'node', 'label': 'Node', 'mono': True, 'width': '190px'},
    {'name': 'text', 'label': 'Message', 'wrap': True},
)


class LogsView(View):
    """The latest lines that pass the filters, the newest on top."""

    name = 'logs'
    title = 'Logs'
    icon = 'subject'
    period = 0.3

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._level, self._node, self._text = 0, '', ''
        self._version = -1
        self._paused = False
        self._nodes: list[str] = []

    def why_not_shown(self) -> str:
        return self.rights.why_not(Verb.SUBSCRIBE, '/rosout')

    def build(self) -> None:
        with ui.element('div').classes('gw-card flush gw-fill'):
            with head('Logs', 'subject'):
                self._count = ui.label('').classes('gw-dim gw-small')
                ui.element('div').classes('gw-spread')
                options = {
                    0: 'All levels',
                    **{number: f'{name} and worse' for number, name in LEVELS.items() if number > 10},
                }
                ui.select(options, value=0, on_change=self._set_level).props(
                    'outlined dense options-dense data-level'
                ).style('width: 160px')
                self._select = (
                    ui.select({'': 'All nodes'}, value='', on_change=self._set_node)
                    .props('outlined dense options-dense data-node')
                    .style('width: 190px')
                )
                ui.input(placeholder='Text', on_change=self._set_text).props(
                    'outlined dense clearable data-filter'
                ).style('width: 190px')
                self._pause = ui.button('Pause', icon='pause', on_click=self._toggle).props(
                    'flat dense no-caps'
                )
            self._table = LiveTable(COLUMNS, empty='No line has come yet.').classes('gw-log-lines')

    def _set_level(self, event: Any) -> None:
        self._level = int(event.value)
        self._again()

    def _set_node(self, event: Any) -> None:
        self._node = str(event.value or '')
        self._again()

    def _set_text(self, event: Any) -> None:
        self._text = str(event.value or '')
        self._again()

    def _again(self) -> None:
        self._version = -1
        self.page.refresh_soon()

    def _toggle(self) -> None:
        self._paused = not self._paused
        self._pause.set_text('Go on' if self._paused else 'Pause')
        self._pause.props(f'icon={"play_arrow" if self._paused else "pause"}')
        self._again()

    def refresh(self) -> None:
        book = self.session.logs
        if self._version == book.version or (self._paused and self._version != -1):
            return
        self._version = book.version
        nodes = book.nodes
        if nodes != self._nodes:
            self._nodes = nodes
            self._select.set_options({'': 'All nodes', **{name: name for name in nodes}}, value=self._node)
        found = book.latest(_SHOWN, least_level=self._level, node=self._node, text=self._text)
        self._count.set_text(
            f'{book.version} lines' + (f', {len(found)} shown' if len(found) < book.version else '')
        )
        self._table.put([log_row(line) for line in found])


def log_row(line: LogLine) -> dict[str, Any]:
    """Return a line as a row of a table with the columns `COLUMNS`."""
    name = line.level_name
    at = local_time(line.stamp) + f'.{int(line.stamp % 1 * 1000):03}'
    row: dict[str, Any] = {
        'key': str(line.number),
        'cells': [
            at,
            {'text': name, 'tone': _TONES.get(name) or 'plain', 'sort': line.level},
            line.node,
            {'text': line.text, 'title': line.place},
        ],
    }
    if name in {'ERROR', 'FATAL'}:
        row['tone'] = 'bad'
    return row
