"""The Record view: a button begins and ends a bag, which all browsers share."""

from __future__ import annotations

from shlex import quote

from nicegui import ui

from goalwire.apps.console.page.parts import LiveTable, forbid, head
from goalwire.apps.console.page.view import Page, View
from goalwire.apps.console.state.live_recording import LiveRecording, Wanted
from goalwire.observe.sizes import size_text
from goalwire.rosbag2.writer import PRESETS

_COLUMNS = (
    {'name': 'name', 'label': 'Topic', 'mono': True, 'clip': True},
    {'name': 'type', 'label': 'Type', 'mono': True, 'clip': True},
    {'name': 'count', 'label': 'Messages', 'align': 'right', 'width': '92px'},
    {'name': 'lost', 'label': 'Lost', 'align': 'right', 'width': '92px'},
)


class RecordView(View):
    """The form for a new bag, and the state of the latest bag."""

    name = 'record'
    title = 'Record'
    icon = 'fiber_manual_record'

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._recording: LiveRecording = self.session.recording

    def build(self) -> None:
        with ui.element('div').classes('gw-card'):
            with head('Record', 'fiber_manual_record'):
                self._state = ui.label('').classes('gw-chip').props('data-record-state')
                ui.element('div').classes('gw-spread')
                self._start = ui.button('Record', icon='fiber_manual_record', on_click=self._begin).props(
                    'unelevated dense no-caps color=negative data-record padding="4px 14px"'
                )
                self._stop = ui.button('Stop recording', icon='stop', on_click=self._end).props(
                    'unelevated dense no-caps color=primary data-end-record padding="4px 14px"'
                )
            self._form = ui.element('div').classes('gw-head')
            with self._form:
                self._names = self._globs('Only names such as', 'all; or /arm/* /tf*', 'data-record-names')
                self._out = self._globs('Leave out', 'none; or /camera/*', 'data-record-out')
                self._preset = (
                    ui.select(list(PRESETS), value='none', label='Compression')
                    .props('outlined dense options-dense data-record-preset')
                    .style('width: 150px')
                )
            ui.label(
                'Topics, services and actions, as they are on the wire. It goes on when this page is closed, '
                'and ends with the console.'
            ).classes('gw-dim gw-small')
            self._where = ui.label('').classes('gw-mono').props('data-record-path')
            self._problem = ui.label('').classes('gw-problem').props('data-record-problem')
            self._loss = ui.label('').classes('gw-note').props('data-record-lost')
            self._next = ui.label('').classes('gw-code').props('data-record-next')
        with ui.element('div').classes('gw-card flush gw-fill'):
            self._table = LiveTable(_COLUMNS, empty='Nothing is recorded yet.')
        for button in (self._start, self._stop):
            forbid(button, self.rights.why_not_record())

    @staticmethod
    def _globs(label: str, placeholder: str, mark: str) -> ui.input:
        return (
            ui.input(label, placeholder=placeholder)
            .props(f'outlined dense stack-label {mark}')
            .style('width: 220px')
        )

    async def _begin(self) -> None:
        wanted = Wanted(_words(self._names.value), _words(self._out.value), str(self._preset.value))
        await self.page.attempt(self._start_as_visitor(wanted))
        self.page.refresh_soon()

    async def _start_as_visitor(self, wanted: Wanted) -> None:
        self.rights.check_to_record()
        await self._recording.start(wanted)
        self.rights.note('record', self._recording.path, 'began')

    async def _end(self) -> None:
        await self.page.attempt(self._end_as_visitor())
        self.page.refresh_soon()

    async def _end_as_visitor(self) -> None:
        self.rights.check_to_record()
        await self._recording.stop()
        self.rights.note('record', self._recording.path, 'ended')

    def refresh(self) -> None:
        recording = self._recording
        runs, has_ended = recording.is_running, bool(recording.path) and not recording.is_running
        counts, lost = recording.counts(), recording.count_lost()
        self._start.set_visibility(not runs)
        self._form.set_visibility(not runs)
        self._stop.set_visibility(runs)
        self._state.set_visibility(bool(recording.path))
        parts = (
            'recording' if runs else 'ended',
            time_text(recording.seconds),
            f'{counts.total():,} messages',
            size_text(recording.byte_count),
        )
        self._state.set_text(' · '.join(parts))
        self._state.classes(add='bad') if runs else self._state.classes(remove='bad')
        self._where.set_text(recording.path or f'into a new folder in {recording.folder}')
        self._problem.set_visibility(bool(recording.problem))
        self._problem.set_text(recording.problem)
        self._loss.set_visibility(lost.total() > 0)
        self._loss.set_text(f'{lost.total():,} messages are not in the bag: see the column Lost')
        self._next.set_visibility(has_ended and not recording.problem)
        self._next.set_text(f'goalwire console --bag {quote(recording.path)}')
        self._table.put(
            [
                {
                    'key': name,
                    'cells': [
                        {'text': name, 'title': name},
                        {'text': type_name.replace('/msg/', '/'), 'title': type_name},
                        {'text': f'{counts[name]:,}', 'sort': counts[name]},
                        {'text': f'{lost[name]:,}' if lost[name] else '', 'sort': lost[name]},
                    ],
                    'tone': 'warn' if lost[name] else '',
                }
                for name, type_name in sorted(recording.types().items())
            ]
        )


def _words(text: str | None) -> tuple[str, ...]:
    return tuple((text or '').replace(',', ' ').split())


def time_text(seconds: float) -> str:
    """Return a duration as minutes and seconds."""
    return f'{int(seconds) // 60}:{int(seconds) % 60:02}'
