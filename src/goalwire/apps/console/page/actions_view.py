"""The Actions view: forms that send goals, and lanes that show the goals of all clients over time."""

from __future__ import annotations

from time import monotonic
from typing import Any

from nicegui import ui

from goalwire.apps.console.page.parts import (
    LiveTable,
    SwimLanes,
    ValueTree,
    forbid,
    head,
    lane_groups,
)
from goalwire.apps.console.page.send_form import SendForm
from goalwire.apps.console.page.view import Page, View, duration
from goalwire.apps.console.state.draft import Draft
from goalwire.errors import GoalwireError, peer_text
from goalwire.observe.clock import time_of_day
from goalwire.observe.goals import Goal
from goalwire.observe.messages import as_data
from goalwire.security.policy import Verb

TONES = {
    'EXECUTING': 'info',
    'SUCCEEDED': 'good',
    'CANCELING': 'warn',
    'CANCELED': 'warn',
    'ABORTED': 'bad',
    'UNKNOWN': 'bad',
}
_SPANS = {30: '30 s', 60: '1 min', 300: '5 min', 1800: '30 min'}
_LABEL = 0.14
"""The fraction of a lane's width that the text before a short bar needs."""


class ActionsView(View):
    """Lanes on top; below, the actions, the form of the chosen one, and the chosen goal."""

    name = 'actions'
    title = 'Actions'
    icon = 'flag'
    period = 0.2

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._form: SendForm | None = None
        self._span = 60
        self._goal: tuple[str, str] | None = None
        self._goal_state: object = None
        self._feedback_shown: object = None
        self._version = -1
        self._put_at = 0.0

    def build(self) -> None:
        self._build_lanes()
        with ui.element('div').classes('gw-side'):
            with ui.element('div').classes('gw-card flush'):
                head('Actions', 'flag')
                self._table = LiveTable(
                    [
                        {'name': 'name', 'label': 'Name', 'mono': True, 'wrap': True},
                        {'name': 'active', 'label': 'Active', 'align': 'right', 'width': '64px'},
                    ],
                    empty='No action servers yet. They appear here as they start.',
                    on_row=self.turning_to(self._choose),
                )
            with ui.element('div').classes('gw-two').style('align-items: start'):
                self._form_card = ui.element('div').classes('gw-card')
                with self._form_card:
                    ui.label('Choose an action to send a goal.').classes('gw-empty')
                self._goal_card = ui.element('div').classes('gw-card').props('data-goal')
                with self._goal_card:
                    ui.label('Choose a goal in the lanes to see its feedback and result.').classes('gw-empty')

    def _build_lanes(self) -> None:
        with ui.element('div').classes('gw-card'):
            with head('Goals', 'view_timeline'):
                self._count = ui.label('').classes('gw-dim gw-small')
                ui.element('div').classes('gw-spread')
                for status in ('EXECUTING', 'SUCCEEDED', 'CANCELED', 'ABORTED'):
                    ui.label(status.lower()).classes(f'gw-chip {TONES[status]}')
                ui.select(_SPANS, value=self._span, on_change=self._set_span).props(
                    'outlined dense options-dense'
                ).style('width: 96px')
                if not self.settings.read_only:
                    ui.button('Cancel all', icon='cancel', on_click=self._cancel_all).props(
                        'flat dense no-caps color=negative data-cancel-all'
                    )
            with ui.element('div').style('max-height: 34vh; overflow: auto; width: 100%'):
                self._lanes = SwimLanes(self._choose_goal)
                self._lanes.set_dark(self.page.is_dark)
                self._no_goals = ui.label('No goal yet. Those of other clients appear here, too.').classes(
                    'gw-empty'
                )

    def set_dark(self, dark: bool) -> None:
        self._lanes.set_dark(dark)

    def _set_span(self, event: Any) -> None:
        self._span = int(event.value)
        self._version = -1
        self.page.refresh_soon()

    # -- refreshing the view ---------------------------------------------------------------------------------

    def refresh(self) -> None:
        goals, now = self.session.goals, monotonic()
        active = goals.active()
        if goals.version == self._version and now - self._put_at < 1.0:
            return
        self._version, self._put_at = goals.version, now
        seen = {action for action in {goal.action for goal in goals} if self.rights.may_look_at_goals(action)}
        active = [goal for goal in active if goal.action in seen]
        ended = sum(1 for goal in goals if goal.action in seen) - len(active)
        shown = [
            goal
            for goal in goals
            if goal.action in seen and (goal.ended is None or goal.ended > now - self._span)
        ]
        self._lanes.set_visibility(bool(shown))
        self._no_goals.set_visibility(not shown)
        self._count.set_text(f'{len(active)} active, {ended} ended')
        if shown:
            self._lanes.put(
                {'now': now, 'span': self._span, 'groups': lane_groups(shown, now, self._span * _LABEL)}
            )
        rows = []
        for name, type_name in self.session.goal_watch.served.items():
            if not self.rights.may_see('action', name):
                continue
            count = sum(1 for goal in active if goal.action == name)
            cell: Any = {'text': str(count), 'tone': 'info', 'sort': count} if count else ''
            rows.append({'key': name, 'cells': [{'text': name, 'title': type_name}, cell]})
        self._table.put(rows)
        self._put_goal()

    def _choose_goal(self, action: str, goal_id: str) -> None:
        self._goal, self._goal_state = (action, goal_id), None
        self._version = -1
        self.page.refresh_soon()

    def _put_goal(self) -> None:
        goal = self.session.goals.get(*self._goal) if self._goal is not None else None
        if goal is None or not self.rights.may_look_at_goals(goal.action):
            return
        state = (goal.goal_id, goal.status, goal.problem, goal.result is not None)
        if state != self._goal_state:
            self._goal_state = state
            self._draw_goal(goal)
        if goal.is_active:
            self._put_feedback(goal)
        if goal.progress is not None:
            self._bar.set_visibility(True)
            self._bar_inner.style(f'width: {goal.progress * 100:.1f}%')
        end = goal.ended if goal.ended is not None else monotonic()
        self._times.set_text(
            f'{time_of_day(goal.began)} · {duration(end - goal.began)}'
            f' · {len(goal.ticks)} feedback'
            + (f' · {goal.progress * 100:.0f} %' if goal.progress is not None else '')
        )

    def _put_feedback(self, goal: Goal) -> None:
        if goal.feedback is not self._feedback_shown:
            self._feedback_shown = goal.feedback
            self._feedback.put(as_data(goal.feedback))

    def _draw_goal(self, goal: Goal) -> None:
        self._goal_card.clear()
        with self._goal_card:
            with head('Goal'):
                ui.label(goal.goal_id[:8]).classes('gw-mono gw-dim').props('data-goal-id').tooltip(
                    goal.goal_id
                )
                ui.label(goal.status.lower()).classes(f'gw-chip {TONES.get(goal.status, "")}').props(
                    'data-status'
                )
                ui.label('sent from here' if goal.is_mine else "another client's").classes('gw-chip')
                ui.element('div').classes('gw-spread')
                if goal.is_active and self.settings.may_send(goal.action):
                    cancel = ui.button('Cancel', icon='cancel', on_click=lambda: self._cancel(goal)).props(
                        'flat dense no-caps color=negative data-cancel'
                    )
                    before = ui.button(icon='history', on_click=lambda: self._cancel_before(goal)).props(
                        'flat dense round size=sm data-cancel-before aria-label="Cancel it and earlier ones"'
                    )
                    before.tooltip('Cancel this goal and those accepted before it')
                    for each in (cancel, before):
                        forbid(each, self.rights.why_not(Verb.CANCEL, goal.action))
            ui.label(goal.action).classes('gw-mono gw-dim')
            self._times = ui.label('').classes('gw-small gw-dim')
            with ui.element('div').classes('gw-bar') as self._bar:
                self._bar_inner = ui.element('div')
            self._bar.set_visibility(goal.progress is not None)
            if goal.problem:
                ui.label(goal.problem).classes('gw-problem')
            if goal.result is not None:
                with ui.element('div').classes('gw-group').props('data-result'):
                    ui.label('Result').classes('gw-group-head')
                    ValueTree(empty='').put(goal.result)
            with ui.element('div').classes('gw-group').props('data-feedback'):
                ui.label('Feedback').classes('gw-group-head')
                self._feedback = ValueTree(empty='None yet.')
                self._feedback_shown = None
                self._put_feedback(goal)
            if goal.request is not None:
                with ui.element('div').classes('gw-group'):
                    ui.label('Goal').classes('gw-group-head')
                    ValueTree(empty='').put(goal.request)

    # -- cancelling ------------------------------------------------------------------------------------------

    async def _cancel(self, goal: Goal) -> None:
        found = await self.page.attempt(self.session.sender.cancel(goal.action, self.rights, goal.goal_id))
        if found is not None:
            self.page.tell('The goal is being cancelled' if found else 'The server cancels no such goal')

    async def _cancel_before(self, goal: Goal) -> None:
        before = goal.accepted
        if not before:
            self.page.tell('The server has not said when it accepted the goal', 'warning')
            return
        found = await self.page.attempt(
            self.session.sender.cancel(goal.action, self.rights, before=before + 1e-6)
        )
        if found is not None:
            self.page.tell(f'{len(found)} goals are being cancelled')

    async def _cancel_all(self) -> None:
        actions = sorted({goal.action for goal in self.session.goals.active()})
        if not actions:
            self.page.tell('No goal is active', 'info')
            return
        if not await self.page.confirm(
            'cancel',
            'all actions',
            'Cancel every goal, whoever has sent it?',
            '\n'.join(actions),
            'Cancel all',
        ):
            return
        count = 0
        for action in actions:
            found = await self.page.attempt(self.session.sender.cancel(action, self.rights))
            count += len(found or ())
        self.page.tell(f'{count} goals are being cancelled')

    # -- sending ---------------------------------------------------------------------------------------------

    def _choose(self, name: str) -> None:
        type_name = self.session.goal_watch.served.get(name)
        if type_name is None:
            return
        self._table.choose(name)
        self._form = None
        self._form_card.clear()
        with self._form_card:
            try:
                target = self.session.sender.target('action', name, type_name)
            except GoalwireError as error:
                ui.label(peer_text(error, 400)).classes('gw-problem')
                return
            with ui.element('div').classes('gw-head'):
                ui.label(name).classes('gw-title gw-mono')
                ui.label(type_name).classes('gw-chip')
            self._form = form = SendForm(self.page, target)
            form.keep_draft(self.name)
            if form.sent:
                form.fill(form.sent[-1].sending.values)
            with ui.element('div').classes('gw-actions gw-send'):
                form.send_button('Send goal', 'data-send-goal', self._send)
                form.deadline_field(None)
                form.yaml_button()
            self._ends = (
                ui.checkbox('Cancel this goal when the page is closed')
                .props('dense size=sm')
                .classes('gw-small')
            )
            with ui.element('div').classes('gw-actions'):
                form.copy_buttons()
            with ui.element('div').classes('gw-group'):
                ui.label('History').classes('gw-group-head')
                form.history()

    def resume(self, draft: Draft) -> bool:
        if self._form is None or self._form.target.name != draft.name:
            if draft.name not in self.session.goal_watch.served:
                return False
            self._choose(draft.name)
        if self._form is not None:
            self._form.restore(draft)
        return True

    async def _send(self) -> None:
        form = self._form
        sending = None if form is None else await form.confirm('Send this goal?', 'Send')
        if form is None or sending is None:
            return
        ends = bool(self._ends.value)
        goal = await self.page.attempt(self.session.sender.send_goal(form.target, sending, self.rights))
        form.put_history()
        if goal is None:
            return
        if ends:
            self.page.own_goals.add((goal.action, goal.goal_id))
        if goal.problem:
            self.page.tell(goal.problem, 'negative')
        self._choose_goal(goal.action, goal.goal_id)
