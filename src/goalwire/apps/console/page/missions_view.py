"""The Missions view: what waits for a person on top, then missions as lanes above the goals."""

from __future__ import annotations

from time import monotonic, time
from typing import TYPE_CHECKING, Any

from nicegui import background_tasks, ui

from goalwire.apps.console.page.parts import LiveTable, SwimLanes, forbid, head, lane_groups
from goalwire.apps.console.page.view import Page, View
from goalwire.apps.console.state.mission_journal import COMMANDS, SeenMission
from goalwire.errors import MissionError, peer_text
from goalwire.observe.clock import local_time
from goalwire.rules.missions.entries import EntryKind, MissionState

if TYPE_CHECKING:
    from goalwire.apps.console.state.session import Session
    from goalwire.missions.journal_store import MissionRow

_SPAN_S = 300
_LABEL = 0.14
"""The fraction of a lane's width that the text before a short bar needs."""
_MOVES = {'again', 'resume', 'undo'}
"""Answers and commands to a mission after which the robot may move: the user must confirm them."""
_LABELS = {
    'done': 'It was done',
    'again': 'Do it again',
    'fail': 'It failed',
    'yes': 'Yes',
    'no': 'No',
    'resume': 'Resume',
    'undo': 'Cancel and undo',
    'cancel': 'Cancel without undo',
}
_NOBODY_TAKES = 'Nobody runs it now: its runner takes the answer when it is started again.'
_TONES = {
    MissionState.RUNNING: 'info',
    MissionState.SUCCEEDED: 'good',
    MissionState.FAILED: 'bad',
    MissionState.CANCELED: 'warn',
}


class MissionsView(View):
    """Questions with their buttons, lanes, and the list of missions."""

    name = 'missions'
    title = 'Missions'
    icon = 'checklist'
    period = 0.5

    @classmethod
    def is_offered(cls, session: Session) -> bool:
        return session.missions is not None

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        assert self.session.missions is not None
        self._journal = self.session.missions
        self._seen: list[SeenMission] = []
        self._problem = ''
        self._is_reading = False
        self._asked: tuple[list[MissionRow], bool] = [], True
        """The missions whose questions are shown, and whether a runner was there."""

    def build(self) -> None:
        self._trouble = ui.label('').classes('gw-problem').props('data-mission-problem')
        self._questions = ui.element('div').props('data-questions')
        with ui.element('div').classes('gw-card'):
            with head('Missions and goals', 'view_timeline'):
                ui.label(str(self._journal.path)).classes('gw-dim gw-small gw-mono')
            with ui.element('div').style('max-height: 45vh; overflow: auto; width: 100%'):
                self._lanes = SwimLanes()
                self._lanes.set_dark(self.page.is_dark)
        with ui.element('div').classes('gw-card flush'):
            self._table = LiveTable(
                [
                    {'name': 'id', 'label': 'Mission', 'mono': True},
                    {'name': 'name', 'label': 'Name'},
                    {'name': 'state', 'label': 'State', 'width': '110px'},
                    {'name': 'since', 'label': 'Since', 'width': '90px'},
                    {'name': 'why', 'label': '', 'wrap': True},
                ],
                empty='No missions yet.',
            )

    def set_dark(self, dark: bool) -> None:
        self._lanes.set_dark(dark)

    # -- refreshing the view ---------------------------------------------------------------------------------

    def refresh(self) -> None:
        if not self._is_reading:
            self._is_reading = True
            background_tasks.create(self._read())
        self._trouble.set_text(self._problem)
        self._trouble.set_visibility(bool(self._problem))
        self._put_questions()
        self._put_lanes()
        self._table.put([self._row(seen) for seen in reversed(self._seen)])

    async def _read(self) -> None:
        try:
            self._seen = await self._journal.look()
            self._problem = ''
        except MissionError as error:
            self._problem = peer_text(error, 400)
        finally:
            self._is_reading = False

    def _put_questions(self) -> None:
        waiting = [seen.row for seen in self._seen if seen.row.state.waits_for_somebody]
        asked = waiting, self._journal.has_runner
        if asked == self._asked:
            return
        self._asked = asked
        self._questions.clear()
        with self._questions:
            for row in waiting:
                with ui.element('div').classes('gw-card').props(f'data-question="{row.id}"'):
                    with head(f'{row.name} waits for you', 'front_hand'):
                        ui.label(row.id).classes('gw-mono gw-dim')
                        ui.label(str(row.state)).classes('gw-chip warn')
                    ui.label(row.why).style('overflow-wrap: anywhere')
                    if not self._journal.has_runner:
                        ui.label(_NOBODY_TAKES).classes('gw-dim')
                    if self.settings.may_send(row.name):
                        self._put_buttons(row, COMMANDS[row.state])

    def _put_buttons(self, row: MissionRow, words: tuple[str, ...]) -> None:
        async def say(word: str) -> None:
            if word in _MOVES and not await self.page.confirm(
                'mission', row.id, f'{_LABELS[word]}? The robot may move then.', row.why, _LABELS[word],
                may_trust=False,
            ):  # fmt: skip
                return
            await self.page.attempt(self._journal.say(row, word, self.rights))

        with ui.element('div').classes('gw-actions'):
            for word in words:
                button = ui.button(_LABELS[word], on_click=lambda word=word: say(word)).props(
                    f'unelevated dense no-caps padding="4px 14px" data-say={word}'
                )
                forbid(button, self.rights.why_not_command(row.name, word))

    def _put_lanes(self) -> None:
        now = time()
        ahead = now - monotonic()
        since = monotonic() - _SPAN_S
        recent = (goal for goal in self.session.goals if goal.ended is None or goal.ended > since)
        shown = self.rights.of_seen_actions(recent)
        below = lane_groups(shown, monotonic(), _SPAN_S * _LABEL)
        for group in below:
            for goal in group['goals']:
                goal['began'] += ahead
                goal['ended'] = None if goal['ended'] is None else goal['ended'] + ahead
                goal['marks'] = [[at + ahead, status] for at, status in goal['marks']]
                goal['ticks'] = [at + ahead for at in goal['ticks']]
        lanes = [_lane(seen, now) for seen in self._seen if _is_recent(seen, now)]
        self._lanes.put({'now': now, 'span': _SPAN_S, 'groups': lanes + below})

    def _row(self, seen: SeenMission) -> dict[str, Any]:
        row = seen.row
        state, why = {'text': str(row.state), 'tone': _TONES.get(row.state, 'warn')}, row.why
        if row.state.is_open and not self._journal.has_runner:
            state['tone'] = 'warn'
            why = f'nobody runs it: {why}' if why else 'nobody runs it'
        return {'key': row.id, 'cells': [row.id, row.name, state, local_time(row.changed), why]}


def _is_recent(seen: SeenMission, now: float) -> bool:
    return seen.row.state.is_open or seen.row.changed > now - _SPAN_S


def _lane(seen: SeenMission, now: float) -> dict[str, Any]:
    """Return a mission as a lane: a bar for each step of the last minutes."""
    bars: dict[int, dict[str, Any]] = {}
    for entry in seen.entries:
        if entry.step < 0:
            continue
        bar = bars.get(entry.step)
        if bar is None:
            title = f'{entry.body.get("kind", "")} {entry.body.get("target", "")}'.strip()
            bar = bars[entry.step] = {
                'id': seen.row.id, 'action': seen.row.id, 'title': title, 'began': entry.at, 'ended': None,
                'status': 'EXECUTING', 'marks': [[entry.at, 'EXECUTING']], 'ticks': [], 'progress': None,
            }  # fmt: skip
        status = bar['status']
        if entry.kind is EntryKind.ENDED:
            status, bar['ended'] = ('ABORTED' if 'error' in entry.body else 'SUCCEEDED'), entry.at
        elif entry.kind is EntryKind.ASKED:
            status = 'UNKNOWN'
        elif entry.kind is EntryKind.INTENT:
            status = 'EXECUTING'
        if status != bar['status']:
            bar['status'] = status
            bar['marks'].append([entry.at, status])
    shown = [bar for bar in bars.values() if bar['ended'] is None or bar['ended'] > now - _SPAN_S]
    name = f'mission {seen.row.name} {seen.row.id}'
    return {'name': name, 'rows': _arrange(shown, now), 'goals': shown}


def _arrange(bars: list[dict[str, Any]], now: float) -> int:
    """Give each bar a row in which its text covers no other one; return the number of rows."""
    free_from: list[float] = []
    for bar in bars:
        row = next((row for row, at in enumerate(free_from) if at <= bar['began']), len(free_from))
        free_from[row : row + 1] = [max(bar['ended'] or now, bar['began'] + _SPAN_S * _LABEL)]
        bar['row'] = row
    return max(len(free_from), 1)
