"""Elements that several views use: live tables, trees of messages, text to copy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from nicegui import ui
from nicegui.element import Element

from goalwire.apps.console.state.goal_text import describe_goal
from goalwire.observe.goals import Goal, lanes

_TICKS_SENT = 120


class LiveTable(Element, component='live_table.js'):
    """A table; `put` sends only the rows that have changed."""

    def __init__(
        self, columns: Sequence[Mapping[str, Any]], *, empty: str, on_row: Callable[[str], Any] | None = None
    ) -> None:
        super().__init__()
        self._props['columns'] = [dict(column) for column in columns]
        self._props['empty'] = empty
        self._sent: dict[str, Any] = {}
        self._order: list[str] = []
        if on_row is not None:
            self.on('row', lambda event: on_row(str(event.args)))

    def put(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Show rows: each has `key`, `cells` (texts, or {text, tone, sort, title}) and perhaps `tone`."""
        order = [row['key'] for row in rows]
        changed = {row['key']: dict(row) for row in rows if self._sent.get(row['key']) != row}
        if not changed and order == self._order:
            return
        update: dict[str, Any] = {'rows': changed}
        if order != self._order:
            update['order'] = order
        self._sent = {row['key']: dict(row) for row in rows}
        self._order = order
        self.run_method('show', update)

    def again(self) -> None:
        """Send all rows with the next `put`, because the browser has recreated the element."""
        self._sent, self._order = {}, []

    def choose(self, key: str | None) -> None:
        """Mark a row."""
        self.run_method('choose', key)


class ValueTree(Element, component='value_tree.js'):
    """A message as a tree."""

    def __init__(self, *, empty: str, on_plot: Callable[[str], Any] | None = None) -> None:
        super().__init__()
        self._props['plots'] = on_plot is not None
        self._props['empty'] = empty
        self._sent: Any = None
        if on_plot is not None:
            self.on('plot', lambda event: on_plot(str(event.args)))

    def put(self, value: Any) -> None:
        """Show a value."""
        if value is not self._sent:
            self._sent = value
            self.run_method('show', value)


class SwimLanes(Element, component='swim_lanes.js'):
    """Goals over time: up to now, or over the whole time of a recording."""

    def __init__(
        self,
        on_goal: Callable[[str, str], Any] | None = None,
        *,
        on_seek: Callable[[float], Any] | None = None,
        on_key: Callable[[str], Any] | None = None,
    ) -> None:
        """`on_seek` makes the lanes a timeline, and gets the clicked time in s; `on_key` gets keys."""
        super().__init__()
        self._props['recording'] = on_seek is not None
        if on_goal is not None:
            self.on('goal', lambda event: on_goal(str(event.args['action']), str(event.args['id'])))
        if on_seek is not None:
            self.on('seek', lambda event: on_seek(float(event.args)))
        if on_key is not None:
            self.on('key', lambda event: on_key(str(event.args)))

    def put(self, data: Mapping[str, Any]) -> None:
        """Show goals."""
        self.run_method('show', dict(data))

    def put_cursor(self, time: float) -> None:
        """Show the position in a recording, in s."""
        self.run_method('set_cursor', round(time, 3))

    def set_dark(self, dark: bool) -> None:
        """Choose the colours."""
        self.props['dark'] = dark
        self.update()


def lane_groups(shown: Iterable[Goal], now: float, margin: float) -> list[dict[str, Any]]:
    """Return goals as lanes for `SwimLanes`; in a lane, bars are at least `margin` s apart."""
    groups: dict[str, dict[str, Any]] = {}
    for goal, row in lanes(shown, now, margin):
        group = groups.setdefault(goal.action, {'name': goal.action, 'rows': 0, 'goals': []})
        group['rows'] = max(group['rows'], row + 1)
        ticks = list(goal.ticks)
        step = max(1, len(ticks) // _TICKS_SENT)
        group['goals'].append(
            {
                'id': goal.goal_id,
                'title': _title(goal),
                'action': goal.action,
                'row': row,
                'began': round(goal.began, 2),
                'ended': None if goal.ended is None else round(goal.ended, 2),
                'status': goal.status,
                'marks': [[round(at, 2), status] for at, status in goal.marks],
                'ticks': [round(at, 2) for at in ticks[::step]],
                'progress': None if goal.progress is None else round(goal.progress, 3),
            }
        )
    return [groups[name] for name in sorted(groups)]


def _title(goal: Goal) -> str:
    """Return what a goal asks for, if this process has sent it, and the beginning of its number."""
    asked = '' if goal.request is None else describe_goal(goal.request)
    return f'{asked}  {goal.goal_id[:8]}' if asked else goal.goal_id[:8]


def head(title: str, icon: str = '') -> ui.element:
    """Write a card's head with its title; what else belongs into the head is written `with head(…):`."""
    with ui.element('div').classes('gw-head') as made:
        if icon:
            ui.icon(icon, size='18px').classes('gw-dim')
        ui.label(title).classes('gw-title')
    return made


def forbid(button: ui.button, reason: str) -> None:
    """Disable a button that the visitor may not press, and show the reason; with '' do nothing."""
    if reason:
        button.disable()
        button.tooltip(reason)
        button.props['data-why'] = reason
        button.props['aria-description'] = reason


def copy_buttons(python: Callable[[], str | None], command: Callable[[], str | None]) -> None:
    """Add two buttons that copy the texts that `python` and `command` return; None copies nothing."""

    def copy(make: Callable[[], str | None], what: str) -> None:
        text = make()
        if text is not None:
            ui.clipboard.write(text)
            ui.notify(f'{what} copied', position='bottom-right', type='positive')

    ui.button('Copy as Python', icon='content_copy', on_click=lambda: copy(python, 'Program')).props(
        'flat dense no-caps size=sm'
    ).classes('gw-quiet')
    ui.button('Copy as command', icon='terminal', on_click=lambda: copy(command, 'Command')).props(
        'flat dense no-caps size=sm'
    ).classes('gw-quiet')


def hold_goal_lines(element: ui.element, *, under: ui.element) -> None:
    """Keep the height of the goals' lines while the mouse is on what lies below them.

    A slider that moves a robot must not go away under the mouse, and another take its place. The height is a
    variable of the style sheet, since an update of the element would replace its own style.
    """
    style = 'document.documentElement.style'
    height = f"getHtmlElement({element.id}).offsetHeight + 'px'"
    under.on('pointerenter', js_handler=f"() => {style}.setProperty('--gw-goal-lines', {height})")
    under.on('pointerleave', js_handler=f"() => {style}.removeProperty('--gw-goal-lines')")
