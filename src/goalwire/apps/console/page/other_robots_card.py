"""The card of the Robot view with the robots that are drawn beside the selected one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.kept import keep_layout
from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.robot_model import scene_of

if TYPE_CHECKING:
    from nicegui.element import Element

    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.robot_watch import RobotWatch


class OtherRobotsCard:
    """A switch for each robot that is not selected. They are drawn only: nothing here moves or stops one."""

    def __init__(self, page: Page, scene: Element) -> None:
        """`scene` is a RobotScene."""
        self._page = page
        self._scene = scene
        self._watches: dict[str, RobotWatch] = {}
        self._notes: dict[str, ui.label] = {}
        self._versions: dict[str, tuple[int, int]] = {}
        self._sent: dict[str, object] = {}
        with ui.element('div').classes('gw-card').props('data-other-robots') as self._card:
            head('Other robots', 'groups')
            self._rows = ui.element('div').classes('gw-stack').style('gap: 4px')
        self._card.set_visibility(False)

    def look(self, selected: str, names: list[str]) -> None:
        """Follow the present robots but the selected one."""
        others = [name for name in names if name != selected]
        if others != list(self._notes):
            self._notes.clear()
            self._rows.clear()
            with self._rows:
                for name in others:
                    self._build_row(name)
        self._card.set_visibility(bool(others))
        hidden = self._page.layout.hidden_robots
        wanted = {name for name in others if name not in hidden}
        for name in self._watches.keys() - wanted:
            self._leave(name)
        for name in sorted(wanted - self._watches.keys()):
            if not self._page.rights.why_not_watch(name):
                self._watches[name] = self._page.session.watch_robot(name)

    def _build_row(self, name: str) -> None:
        with ui.element('div'):
            is_on = name not in self._page.layout.hidden_robots
            switch = ui.switch(name or '/', value=is_on).props('dense size=sm')
            switch.props['data-other-robot'] = name
            switch.on_value_change(lambda event: self._switch(name, bool(event.value)))
            self._notes[name] = ui.label('').classes('gw-small gw-dim')
            self._notes[name].props['data-other-robot-note'] = name

    def _switch(self, name: str, on: bool) -> None:
        hidden = [each for each in self._page.layout.hidden_robots if each != name]
        self._page.layout.hidden_robots = hidden if on else [*hidden, name]
        keep_layout(self._page)
        self.look(self._page.robot, [self._page.robot, *self._notes])
        self._page.refresh_soon()

    def refresh(self, selected: RobotWatch) -> None:
        """Send the changes of the robots to the scene; `selected` says in which frame they are drawn."""
        top, _ = selected.pose()
        changed: dict[str, Any] = {}
        for name, note in self._notes.items():
            watch = self._watches.get(name)
            if watch is None:
                note.set_text(self._page.rights.why_not_watch(name))
                continue
            model, own_top = watch.model, watch.pose()[0]
            if model is None:
                note.set_text('its robot_description has not come yet')
                continue
            meshes = self._page.session.meshes
            if self._versions.get(name) != (watch.version, meshes.version):
                self._versions[name] = watch.version, meshes.version
                self._sent.pop(name, None)
                shapes, _, _ = scene_of(model, meshes)
                self._scene.run_method('set_model', shapes, name)
            is_joined = own_top == top
            note.set_text('' if is_joined else _why_not_drawn(own_top, top))
            state = {'links': watch.link_poses(), 'visible': is_joined, 'stale': not watch.is_fresh}
            if state != self._sent.get(name):
                self._sent[name] = changed[name] = state
        if changed:
            self._scene.run_method('set_others', changed)

    def _leave(self, name: str) -> None:
        self._page.session.leave_robot(self._watches.pop(name))
        self._sent.pop(name, None)
        if self._versions.pop(name, None) is not None:
            self._scene.run_method('set_others', {name: None})

    def close(self) -> None:
        """End the subscriptions."""
        for watch in self._watches.values():
            self._page.session.leave_robot(watch)
        self._watches.clear()


def _why_not_drawn(own: str, top: str) -> str:
    return f"not drawn: no transform joins its frame '{own[:60]}' to '{top[:60]}'"
