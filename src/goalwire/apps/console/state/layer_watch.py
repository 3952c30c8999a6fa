"""The layers of the 3D view as they are now: one for each topic that can be drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from time import monotonic
from typing import Any

import goalwire
from goalwire.apps.console.state.layers import (
    EMPTY,
    MAP,
    MARKER,
    MARKERS,
    PATH,
    SCAN,
    Drawing,
    Markers,
    draw_map,
    draw_path,
    draw_scan,
)
from goalwire.apps.console.state.ownership import may_stop
from goalwire.apps.console.state.sensed_layers import (
    CAMERA,
    CLOUD,
    ODOMETRY,
    POSE,
    POSE_WITH_COVARIANCE,
    draw_camera,
    draw_cloud,
    draw_picture,
    draw_pose,
)
from goalwire.apps.console.state.topics import Reading, Topics
from goalwire.errors import RemoteError, peer_text
from goalwire.idl.pictures import IMAGE

_DRAWN: dict[str, Callable[[Any], Drawing]] = {
    MAP: draw_map,
    SCAN: draw_scan,
    PATH: draw_path,
    CLOUD: draw_cloud,
    CAMERA: draw_camera,
    POSE: draw_pose,
    POSE_WITH_COVARIANCE: draw_pose,
    ODOMETRY: draw_pose,
}
KINDS = {
    MAP: 'map',
    SCAN: 'scan',
    PATH: 'path',
    MARKER: 'markers',
    MARKERS: 'markers',
    CLOUD: 'points',
    CAMERA: 'camera',
    IMAGE: 'picture',
    POSE: 'pose',
    POSE_WITH_COVARIANCE: 'pose',
    ODOMETRY: 'odometry',
}
_OFF_AT_FIRST = frozenset({'points', 'picture', 'odometry'})
"""Kinds that are off at first: the robot itself shows its odometry, and clouds and pictures are large."""
MOST_LAYERS = 30
_PERIODS_S = {'map': 1.0, 'picture': 0.5}
"""Shortest time between two drawings of a kind, in s, if not 0: a map's picture takes tens of ms to make."""


class Layer:
    """One topic that can be drawn. It is subscribed to only while it is on."""

    def __init__(self, topics: Topics, topic: str, type_name: str, camera: str = '') -> None:
        """`camera` is the topic with the CameraInfo of a picture."""
        self.topic = topic
        self.kind = KINDS[type_name]
        self.problem = ''
        self.drawing = EMPTY
        self._topics = topics
        self._type_name = type_name
        self._camera_topic = camera
        self._camera: Reading | None = None
        self._reading: Reading | None = None
        self._markers = Markers()
        self._seen: object = None
        self._drawn_at = -math.inf

    @property
    def is_on(self) -> bool:
        """True while the layer is subscribed to its topic."""
        return self._reading is not None

    def switch_on(self) -> None:
        """Subscribe. A type that is unknown here becomes the layer's problem."""
        if self._reading is not None:
            return
        self.problem = ''
        listener = self._markers.take if self.kind == 'markers' else None
        try:
            if self._camera_topic:
                self._camera = self._topics.read(self._camera_topic, CAMERA)
            self._reading = self._topics.read(self.topic, self._type_name, listener)
        except goalwire.GoalwireError as error:
            self.switch_off()
            self.problem = peer_text(error, 300)

    def switch_off(self) -> None:
        """End the subscription, and forget what was drawn."""
        for reading in (self._reading, self._camera):
            if reading is not None:
                reading.close()
        self._reading, self._camera, self._markers, self._seen = None, None, Markers(), None
        self.drawing, self.problem, self._drawn_at = EMPTY, '', -math.inf

    def update(self, now: float) -> None:
        """Draw the latest message, unless it is drawn already."""
        if self._reading is None or now - self._drawn_at < _PERIODS_S.get(self.kind, 0.0):
            return
        reader = self._reading.reader
        self._markers.delete_expired(now)
        seen: object = self._markers.version if self.kind == 'markers' else reader.count
        if self._camera is not None:
            seen = reader.count, self._camera.reader.count
        if reader.latest is None or seen == self._seen:
            return
        self._seen, self._drawn_at = seen, now
        try:
            drawing = self._draw(reader.latest)
            if drawing != self.drawing:  # An equal drawing, as of a still camera, is not sent again.
                self.drawing = drawing
            self.problem = ''
        except goalwire.GoalwireError as error:
            self.problem = peer_text(error, 300)  # The layer keeps its previous drawing.

    def _draw(self, message: Any) -> Drawing:
        if self.kind == 'markers':
            return self._markers.draw()
        if self._camera is None:
            return _DRAWN[self._type_name](message)
        camera = self._camera.reader.latest
        if camera is None:
            raise RemoteError(f'{self._camera_topic} has not come yet')
        return draw_picture(message, camera)


def _camera_of(picture: str) -> str:
    """Return the topic on which ROS's cameras publish the CameraInfo of a picture."""
    return f'{picture.rpartition("/")[0]}/camera_info'


class LayerWatch:
    """The layers of one robot, for one page."""

    def __init__(
        self,
        node: goalwire.Node,
        topics: Topics,
        may_read: Callable[[str], bool],
        switched: Mapping[str, bool],
    ) -> None:
        """`may_read` returns True for a topic whose messages may be drawn.

        `switched` has the topics whose layers the visitor has switched on or off.
        """
        self.layers: dict[str, Layer] = {}
        self._node = node
        self._topics = topics
        self._may_read = may_read
        self._switched = switched

    def look(self, robot: str, robots: Collection[str]) -> None:
        """Find the layers of a robot in the graph. New ones are on, but for costmaps and _OFF_AT_FIRST."""
        graph = self._node.graph
        drawn = {
            topic: type_name
            for topic, types in graph.topics()
            for type_name in types[:1]
            if type_name in KINDS
            and graph.publishers(topic)
            and may_stop(topic, robot, robots)
            and self._may_read(topic)
        }
        found = [
            (topic, type_name, _camera_of(topic) if type_name == IMAGE else '')
            for topic, type_name in drawn.items()
            if type_name != IMAGE or drawn.get(_camera_of(topic)) == CAMERA
        ][:MOST_LAYERS]
        for topic in self.layers.keys() - {topic for topic, _, _ in found}:
            self.layers.pop(topic).switch_off()
        for topic, type_name, camera in found:
            if topic not in self.layers:
                layer = self.layers[topic] = Layer(self._topics, topic, type_name, camera)
                at_first = 'costmap' not in topic and layer.kind not in _OFF_AT_FIRST
                if self._switched.get(topic, at_first):
                    layer.switch_on()

    def update(self) -> None:
        """Draw the new messages of all layers."""
        now = monotonic()
        for layer in self.layers.values():
            layer.update(now)

    def close(self) -> None:
        """End all subscriptions."""
        for layer in self.layers.values():
            layer.switch_off()
        self.layers.clear()
