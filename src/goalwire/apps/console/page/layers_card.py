"""The card of the Robot view with a switch for each layer of the 3D scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.kept import keep_layout
from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.layer_watch import LayerWatch
from goalwire.apps.console.state.layers import place_frames
from goalwire.security.policy import Verb

if TYPE_CHECKING:
    from nicegui.element import Element

    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.layer_watch import Layer
    from goalwire.apps.console.state.robot_watch import RobotWatch


class LayersCard:
    """Switches of layers, each with a note on the drawn layer or its problem. Sends only changes."""

    def __init__(self, page: Page, scene: Element) -> None:
        """`scene` is a RobotScene. Only topics are drawn that the visitor may subscribe to."""
        rights = page.rights
        self._page = page
        self._session = session = page.session
        self._scene = scene
        self._watch = LayerWatch(
            session.node,
            session.topics,
            lambda topic: rights.may(Verb.SUBSCRIBE, topic),
            page.layout.layers,
        )
        self._notes: dict[str, ui.label] = {}
        self._sent: dict[str, object] = {}
        self._placed: dict[str, object] = {}
        with ui.element('div').classes('gw-card').props('data-layers') as self._card:
            head('Layers', 'layers')
            self._rows = ui.element('div').classes('gw-stack').style('gap: 4px')
        self._card.set_visibility(False)

    def look(self, robot: str) -> None:
        """Find the layers of a robot in the graph."""
        self._watch.look(robot, self._session.vitals)
        layers = self._watch.layers
        self._card.set_visibility(bool(layers))
        if layers.keys() != self._notes.keys():
            self._rows.clear()
            self._notes.clear()
            with self._rows:
                for topic in sorted(layers):
                    self._build_row(layers[topic])

    def _build_row(self, layer: Layer) -> None:
        with ui.element('div'):
            switch = ui.switch(f'{layer.kind}  {layer.topic}', value=layer.is_on).props('dense size=sm')
            switch.props['data-layer'] = layer.topic
            switch.on_value_change(lambda event: self._switch(layer, bool(event.value)))
            self._notes[layer.topic] = ui.label('').classes('gw-small gw-dim')
            self._notes[layer.topic].props['data-layer-note'] = layer.topic

    def _switch(self, layer: Layer, on: bool) -> None:
        if on:
            layer.switch_on()
        else:
            layer.switch_off()
        self._page.layout.layers[layer.topic] = on
        keep_layout(self._page)

    def refresh(self, robot: RobotWatch) -> None:
        """Send changes to the scene: the shapes of layers, and the poses of their frames."""
        self._watch.update()
        fixed, _ = robot.pose()
        shapes: dict[str, Any] = dict.fromkeys(self._sent.keys() - self._watch.layers.keys())
        places: dict[str, Any] = {}
        for topic, layer in self._watch.layers.items():
            if self._sent.get(topic) is not layer.drawing:
                shapes[topic] = layer.drawing.shapes if layer.is_on else None
            placed = place_frames(layer.drawing.shapes, fixed, robot.frames)
            if topic in shapes or placed != self._placed.get(topic):
                places[topic] = placed
            self._notes[topic].set_text(
                _note(layer, [name for name in placed if placed[name] is None], fixed)
            )
        if shapes or places:
            self._scene.run_method('set_layers', {'shapes': shapes, 'places': places})
        self._sent = {topic: layer.drawing for topic, layer in self._watch.layers.items()}
        self._placed |= places

    def close(self) -> None:
        """End the subscriptions."""
        self._watch.close()


def _note(layer: Layer, lost: list[str], fixed: str) -> str:
    """Return the note under a layer's switch."""
    if layer.problem:
        return layer.problem
    if not layer.is_on:
        return ''
    if lost:
        return f"not drawn: no transform joins its frame '{lost[0][:60]}' to '{fixed[:60]}'"
    return layer.drawing.note or 'no message yet'
