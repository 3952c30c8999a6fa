"""Layers of the 3D view: turns maps, scans, markers and paths into shapes in their frames.

A drawing is data for the page: a list of shapes for each frame. `page/scene_layers` draws each kind of them.
"""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Collection, Mapping
from typing import Any, TypeAlias

import numpy as np

from goalwire.apps.console.state.frames import numbers_of
from goalwire.apps.console.state.robot_model import root_pose
from goalwire.errors import RemoteError
from goalwire.idl.png import png
from goalwire.records import record
from goalwire.transforms.rigid import Rigid, normalize

Shape: TypeAlias = dict[str, Any]

MAP = 'nav_msgs/msg/OccupancyGrid'
SCAN = 'sensor_msgs/msg/LaserScan'
PATH = 'nav_msgs/msg/Path'
MARKER = 'visualization_msgs/msg/Marker'
MARKERS = 'visualization_msgs/msg/MarkerArray'

MOST_CELLS_A_SIDE = 1024
MOST_POINTS = 20_000
MOST_MARKERS = 1_000

_SCAN_COLOUR = [0.9, 0.15, 0.2, 1.0]
_PATH_COLOUR = [0.05, 0.6, 0.35, 1.0]
_CUBE, _SPHERE, _CYLINDER, _LINE_STRIP, _LINE_LIST = 1, 2, 3, 4, 5
_ADD, _DELETE, _DELETE_ALL = 0, 2, 3
"""Constants of visualization_msgs/msg/Marker: types and actions."""
_ARROW_M = 0.35
_SOLIDS = {_CUBE: 'box', _SPHERE: 'sphere', _CYLINDER: 'cylinder'}
_LINES = {_LINE_STRIP: 'line', _LINE_LIST: 'segments'}


@record
class Drawing:
    """The shapes of one layer by frame, and a sentence about omitted parts."""

    shapes: dict[str, list[Shape]]
    note: str = ''


EMPTY = Drawing({})


# -- maps ----------------------------------------------------------------------------------------------------


def draw_map(message: Any) -> Drawing:
    """Return a nav_msgs/msg/OccupancyGrid as a picture on a plane, with row 0 at its lower edge.

    A map of more cells a side than MOST_CELLS_A_SIDE is drawn coarser, and the note says so. A coarse cell
    has the highest value of its cells, so no wall is lost. Raises RemoteError for a map whose number of cells
    is not width x height, or whose cells have no valid size.
    """
    info = message.info
    width, height, resolution = info.width, info.height, info.resolution
    cells = np.asarray(message.data, np.int8)
    if not width or not height or len(cells) != width * height:
        raise RemoteError(f'the map should have {width} x {height} cells, but has {len(cells)}')
    if not (math.isfinite(resolution) and resolution > 0):
        raise RemoteError(f'the map says that a cell is {resolution} m wide')
    factor = -(-max(width, height) // MOST_CELLS_A_SIDE)
    coarse = _coarser(cells.reshape(height, width), factor)
    rows, columns = coarse.shape
    shape = {
        'kind': 'map',
        'pose': numbers_of(pose_of(info.origin)),
        'size': [columns * factor * resolution, rows * factor * resolution],
        'cells': [columns, rows],
        'picture': f'data:image/png;base64,{b64encode(png(_colours(coarse)[::-1])).decode()}',
    }
    note = f'{width} x {height} cells'
    if factor > 1:
        note += f', drawn coarser: {factor} x {factor} cells as one'
    return Drawing({_frame(message): [shape]}, note)


def _coarser(cells: np.ndarray[Any, Any], factor: int) -> np.ndarray[Any, Any]:
    """Return the highest value of each block of factor x factor cells; cells beyond the edge are unknown."""
    if factor == 1:
        return cells
    height, width = cells.shape
    cells = np.pad(cells, ((0, -height % factor), (0, -width % factor)), constant_values=-1)
    rows = np.maximum.reduce([cells[start::factor] for start in range(factor)])
    coarse: np.ndarray[Any, Any] = np.maximum.reduce([rows[:, start::factor] for start in range(factor)])
    return coarse


def _colours(cells: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return red, green, blue for each cell: free is white, occupied is black, unknown is a greenish grey."""
    grey = (255 - np.clip(cells, 0, 100).astype(np.uint16) * 255 // 100).astype(np.uint8)
    colours = np.stack([grey] * 3, axis=-1)
    colours[cells < 0] = (112, 137, 134)  # the colours of rviz
    return colours


# -- scans and paths -----------------------------------------------------------------------------------------


def draw_scan(message: Any) -> Drawing:
    """Return a sensor_msgs/msg/LaserScan as points. Ranges that are not within its limits are left out."""
    ranges = np.asarray(message.ranges, np.float64)
    step = max(1, -(-len(ranges) // MOST_POINTS))
    angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
    with np.errstate(invalid='ignore'):
        is_hit = np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max)
    is_hit &= np.isfinite(angles)
    hits, angles = ranges[is_hit][::step], angles[is_hit][::step]
    spots = np.stack([hits * np.cos(angles), hits * np.sin(angles), np.zeros(len(hits))], axis=-1)
    shape = {'kind': 'points', 'spots': spots.round(3).ravel().tolist(), 'rgba': _SCAN_COLOUR}
    return Drawing({_frame(message): [shape]}, _count(len(hits), 'point'))


def draw_path(message: Any) -> Drawing:
    """Return a nav_msgs/msg/Path, in the frame of the whole path, as a line with an arrow at its last pose.

    The arrow shows where the goal of any client leads, though only that client knows its request.
    """
    poses = message.poses[:MOST_POINTS]
    spots = _spots(each.pose.position for each in poses)
    shapes: list[Shape] = [{'kind': 'line', 'spots': spots, 'rgba': _PATH_COLOUR, 'width': 0.05}]
    if message.poses:
        shapes += arrow(pose_of(message.poses[-1].pose), _PATH_COLOUR)
    note = _count(len(message.poses), 'pose')
    if len(message.poses) > MOST_POINTS:
        note += f', the first {MOST_POINTS} are drawn'
    return Drawing({_frame(message): shapes}, note)


# -- markers -------------------------------------------------------------------------------------------------


class Markers:
    """The markers of one topic: each message adds, changes or deletes some."""

    def __init__(self) -> None:
        self.version = 0
        """A number that grows with each change."""
        self._kept: dict[tuple[str, int], tuple[Any, float]] = {}
        self._refused = False

    def take(self, message: Any, at: float) -> None:
        """Take a Marker or a MarkerArray that came at a time, in s."""
        self.version += 1
        for marker in message.markers if hasattr(message, 'markers') else [message]:
            key = (marker.ns, marker.id)
            if marker.action == _DELETE_ALL:
                self._kept.clear()
                self._refused = False
            elif marker.action == _DELETE:
                self._kept.pop(key, None)
            elif marker.action == _ADD and (key in self._kept or len(self._kept) < MOST_MARKERS):
                life = marker.lifetime.sec + marker.lifetime.nanosec / 1e9
                self._kept[key] = (marker, at + life if life > 0 else math.inf)
            elif marker.action == _ADD:
                self._refused = True

    def delete_expired(self, now: float) -> None:
        """Delete the markers whose lifetime is over."""
        over = [key for key, (_, end) in self._kept.items() if end <= now]
        for key in over:
            del self._kept[key]
        self.version += bool(over)

    def draw(self) -> Drawing:
        """Return the markers as shapes."""
        shapes: dict[str, list[Shape]] = {}
        left, drawn, strange = MOST_POINTS, 0, 0
        for marker, _ in self._kept.values():
            shape = _marker_shape(marker, left)
            if shape is None:
                strange += 1
                continue
            left -= len(shape.get('spots', ())) // 3
            drawn += 1
            shapes.setdefault(_frame(marker), []).append(shape)
        parts = [_count(drawn, 'marker')]
        if strange:
            parts.append(f'not drawn, since they are too large or have other types: {strange}')
        if self._refused:
            parts.append(f'more than {MOST_MARKERS} are not kept')
        return Drawing(shapes, '; '.join(parts))


def _marker_shape(marker: Any, most_points: int) -> Shape | None:
    """Return a marker as a shape; None for an unknown type, too many points, or NaN and infinity."""
    size = [marker.scale.x, marker.scale.y, marker.scale.z]
    rgba = [marker.color.r, marker.color.g, marker.color.b, marker.color.a]
    pose = pose_of(marker.pose)
    if not all(map(math.isfinite, (*size, *rgba, *numbers_of(pose)))):
        return None
    shape: Shape = {'pose': numbers_of(pose), 'rgba': rgba}
    if marker.type in _SOLIDS:
        return shape | {'kind': _SOLIDS[marker.type], 'size': size}
    if marker.type in _LINES and len(marker.points) <= most_points:
        spots = _spots(marker.points)
        if len(spots) < 3 * len(marker.points):
            return None
        return shape | {'kind': _LINES[marker.type], 'spots': spots, 'width': size[0]}
    return None


# -- frames --------------------------------------------------------------------------------------------------


def pose_of(pose: Any) -> Rigid:
    """Return the transform of a geometry_msgs/msg/Pose; as in rviz, a zero quaternion means no rotation."""
    place, turn = pose.position, pose.orientation
    return Rigid((place.x, place.y, place.z), normalize((turn.x, turn.y, turn.z, turn.w)))


def arrow(pose: Rigid, colour: list[float]) -> list[Shape]:
    """Return an arrow along a pose's x axis, or an empty list if a number of the pose is not finite."""
    numbers = [round(number, 5) for number in (*pose.translation, *pose.rotation)]
    if not all(map(math.isfinite, numbers)):
        return []
    tip, barb, height = _ARROW_M, _ARROW_M - 0.1, 0.02
    spots = [
        *(0.0, 0.0, height, tip, 0.0, height),
        *(tip, 0.0, height, barb, 0.07, height),
        *(tip, 0.0, height, barb, -0.07, height),
    ]
    return [{'kind': 'segments', 'pose': numbers, 'spots': spots, 'rgba': colour, 'width': 0.025}]


def place_frames(
    names: Collection[str], fixed: str, frames: Mapping[str, tuple[str, Rigid]]
) -> dict[str, list[float] | None]:
    """Return the pose of each frame in the fixed frame; None for a frame without a connection to it."""
    placed: dict[str, list[float] | None] = {}
    for name in names:
        top, pose = root_pose(name, frames)
        placed[name] = numbers_of(pose) if top == fixed else None
    return placed


def _frame(message: Any) -> str:
    return str(message.header.frame_id).lstrip('/')


def _count(number: int, name: str) -> str:
    return f'{number} {name}{"" if number == 1 else "s"}'


def _spots(points: Any) -> list[float]:
    """Return x, y, z of all points in a row; points with numbers that are not finite are left out."""
    found: list[float] = []
    for point in points:
        if math.isfinite(point.x) and math.isfinite(point.y) and math.isfinite(point.z):
            found += (round(point.x, 3), round(point.y, 3), round(point.z, 3))
    return found
