"""The card of the Robot view with the frames of TF: which one stands still, their axes, and their tree."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.kept import keep_layout
from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.frames import MOST_AXES, Placed, numbers_of, place_all, tree_of
from goalwire.transforms.rigid import IDENTITY, Rigid, yaw_of

if TYPE_CHECKING:
    from nicegui.element import Element

    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.robot_watch import RobotWatch

_TOP = ''
"""The choice of the topmost frame above the robot."""


class FramesCard:
    """Chooses the fixed frame and the axes in the scene. Sends only changes."""

    def __init__(self, page: Page, scene: Element) -> None:
        """`scene` is a RobotScene."""
        self._page = page
        self._scene = scene
        self._layout = page.layout
        self._known: object = None
        self._sent: object = None
        self._chosen = ''
        with ui.element('div').classes('gw-card').props('data-frames') as self._card:
            head('Frames', 'account_tree')
            self._fixed = ui.select({}, label='Fixed frame: it stands still', on_change=self._fix).props(
                'outlined dense options-dense data-fixed-frame'
            )
            self._fixed.style('width: 100%')
            with ui.element('div').classes('gw-actions'):
                ui.switch('Axes', value=self._layout.axes, on_change=self._switch_axes).props(
                    'dense size=sm data-axes'
                )
                ui.switch('Names', value=self._layout.axis_names, on_change=self._switch_names).props(
                    'dense size=sm data-axis-names'
                )
            self._note = ui.label('').classes('gw-small gw-dim').props('data-frames-note')
            with ui.expansion('Frame tree').props('dense data-frame-tree').style('width: 100%'):
                self._tree = ui.tree(
                    [], label_key='id', tick_strategy='strict', on_tick=self._tick, on_select=self._select
                ).props('dense no-transition')
                self._place = ui.label('').classes('gw-small gw-dim gw-mono').props('data-frame-place')
        self._card.set_visibility(False)

    # -- what the visitor chooses ----------------------------------------------------------------------------

    def _fix(self, event: Any) -> None:
        if event.value is not None and event.value != self._layout.fixed_frame:
            self._layout.fixed_frame = str(event.value)
            self._keep()

    def _switch_axes(self, event: Any) -> None:
        self._layout.axes = bool(event.value)
        self._keep()

    def _switch_names(self, event: Any) -> None:
        self._layout.axis_names = bool(event.value)
        self._keep()

    def _tick(self, event: Any) -> None:
        shown = set(event.value)
        self._layout.hidden_frames = [name for name in self._names() if name not in shown]
        self._keep()

    def _select(self, event: Any) -> None:
        self._chosen = str(event.value or '')
        self._page.refresh_soon()

    def _keep(self) -> None:
        keep_layout(self._page)
        self._page.refresh_soon()

    def _names(self) -> list[str]:
        return self._known[0] if isinstance(self._known, tuple) else []

    # -- what is there ---------------------------------------------------------------------------------------

    def refresh(self, watch: RobotWatch) -> None:
        """Send the changes of the frames to the scene."""
        top, _ = watch.pose()
        placed = place_all(watch.frames)
        self._card.set_visibility(bool(placed))
        parents = {name: parent for name, (parent, _) in watch.frames.items()}
        known = (sorted(placed), parents, top)
        if known != self._known:
            self._known = known
            self._put_names(watch, placed, top)
        fixed = placed.get(self._layout.fixed_frame)
        is_joined = fixed is not None and fixed.top == top
        pose = fixed.pose if fixed is not None and is_joined else IDENTITY
        axes: dict[str, list[float]] = {}
        if self._layout.axes:
            hidden = set(self._layout.hidden_frames)
            shown = [name for name, at in placed.items() if at.top == top and name not in hidden]
            axes = {name: numbers_of(placed[name].pose) for name in sorted(shown)[:MOST_AXES]}
        state = {'world': numbers_of(pose.inverse()), 'axes': axes, 'names': self._layout.axis_names}
        if state != self._sent:
            self._sent = state
            self._scene.run_method('set_frames', state)
        self._note.set_text(_note(placed, top, '' if is_joined else self._layout.fixed_frame))
        chosen = placed.get(self._chosen)
        shown_in = self._layout.fixed_frame if is_joined else top
        self._place.set_text(
            ''
            if chosen is None or chosen.top != top
            else _place_text(self._chosen, pose.inverse().after(chosen.pose), shown_in)
        )

    def _put_names(self, watch: RobotWatch, placed: dict[str, Placed], top: str) -> None:
        joined = sorted(name for name, at in placed.items() if at.top == top)
        fixed = self._layout.fixed_frame
        options = {_TOP: f'{top} (topmost)'} | {name: name for name in joined if name != top}
        if fixed not in options:
            options[fixed] = f'{fixed} (not joined)'  # it may come later, as after a reload
        self._fixed.set_options(options, value=fixed)
        self._tree.props['nodes'] = tree_of(watch.frames, placed)
        hidden = set(self._layout.hidden_frames)
        self._tree.props['ticked'] = [name for name in sorted(placed) if name not in hidden]
        self._tree.props['expanded'] = sorted(placed)
        self._tree.update()


def _note(placed: dict[str, Placed], top: str, missing: str) -> str:
    """Return the line about frames that are not drawn."""
    apart = sorted({at.top for at in placed.values()} - {top})
    text = f'{len(placed)} frames'
    if missing:
        text += f"; no transform joins '{missing[:60]}' to '{top[:60]}': '{top[:60]}' stands still"
    if apart:
        text += f"; not joined to '{top[:60]}': '{apart[0][:60]}'"
        text += f' and {len(apart) - 1} more' if len(apart) > 1 else ''
    if len(placed) > MOST_AXES:
        text += f'; axes of at most {MOST_AXES} are drawn'
    return text


def _place_text(name: str, pose: Rigid, fixed: str) -> str:
    x, y, z = pose.translation
    yaw = math.degrees(yaw_of(pose.rotation))
    return f'{name} in {fixed}: {x:+.3f} {y:+.3f} {z:+.3f} m, yaw {yaw:+.1f}°'
