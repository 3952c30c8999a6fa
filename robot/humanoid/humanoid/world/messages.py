"""The world as ROS messages: markers to display it, the map, and laser scans."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from builtin_interfaces.msg import Time as TimeMsg
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import Marker, MarkerArray

from humanoid.world.scene import BEAMS, GREATEST_RANGE, LEAST_RANGE
from humanoid.world.solids import Array, Block, Outlines, Solid

FRAME = 'map'
WALL_ALPHA = 0.45  # walls are transparent, so that the robot behind them can be seen
FREE, OCCUPIED = 0, 100
MARGIN = 0.5  # m by which the map extends beyond the outermost things
EMPTY_SIZE = 10.0  # m: half the side of the map of an empty world


def markers(solids: Sequence[Solid], stamp: TimeMsg) -> list[Marker]:
    """Make a marker of each solid, a box or a cylinder; its namespace is the kind, its id counts from 0."""
    count: dict[str, int] = {}
    made = []
    for solid in solids:
        marker = Marker(ns=solid.kind, id=count.get(solid.kind, 0), action=Marker.ADD)
        count[solid.kind] = marker.id + 1
        marker.header.frame_id, marker.header.stamp = FRAME, stamp
        place = marker.pose.position
        place.x, place.y, place.z = solid.x, solid.y, solid.height / 2.0
        size = marker.scale
        if isinstance(solid, Block):
            marker.type = Marker.CUBE
            turn = marker.pose.orientation
            turn.z, turn.w = math.sin(solid.yaw / 2.0), math.cos(solid.yaw / 2.0)
            size.x, size.y, size.z = solid.length, solid.width, solid.height
        else:
            marker.type = Marker.CYLINDER
            marker.pose.orientation.w = 1.0
            size.x = size.y = 2.0 * solid.radius
            size.z = solid.height
        marker.color.r, marker.color.g, marker.color.b = solid.colour
        marker.color.a = WALL_ALPHA if solid.kind == 'wall' else 1.0
        marker.text = solid.name
        made.append(marker)
    return made


def marker_array(solids: Sequence[Solid], stamp: TimeMsg) -> MarkerArray:
    """Make a MarkerArray that first deletes all earlier markers."""
    clear = Marker(action=Marker.DELETEALL)
    clear.header.frame_id, clear.header.stamp = FRAME, stamp
    return MarkerArray(markers=[clear, *markers(solids, stamp)])


def occupancy(solids: Sequence[Solid], resolution: float, stamp: TimeMsg) -> OccupancyGrid:
    """Make the map, with cells of `resolution` m: cells with `solids` are occupied, all others free."""
    corners = np.array([corner for solid in solids for corner in _bounds(solid)]).reshape(-1, 2)
    if len(corners):
        low, high = corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN
    else:
        low, high = np.full(2, -EMPTY_SIZE), np.full(2, EMPTY_SIZE)
    columns, rows = (math.ceil(side / resolution) for side in high - low)
    x = low[0] + (np.arange(columns) + 0.5) * resolution
    y = low[1] + (np.arange(rows) + 0.5) * resolution
    centres = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    outlines = Outlines([_as_thick_as(solid, resolution) for solid in solids])
    near = np.concatenate([outlines.distance(part) for part in np.array_split(centres, max(rows // 8, 1))])
    message = OccupancyGrid()
    message.header.frame_id, message.header.stamp = FRAME, stamp
    message.info.map_load_time, message.info.resolution = stamp, resolution
    message.info.width, message.info.height = columns, rows
    message.info.origin.position.x, message.info.origin.position.y = float(low[0]), float(low[1])
    message.info.origin.orientation.w = 1.0
    message.data = np.where(near <= 0.0, OCCUPIED, FREE).astype(np.int8)
    return message


def _as_thick_as(solid: Solid, cell: float) -> Solid:
    """Return the solid, at least a cell thick: a thinner solid could lie between the centres of cells."""
    if isinstance(solid, Block):
        return replace(solid, length=max(solid.length, cell), width=max(solid.width, cell))
    return replace(solid, radius=max(solid.radius, cell))


def _bounds(solid: Solid) -> Iterable[Sequence[float]]:
    if isinstance(solid, Block):
        return [[float(x), float(y)] for x, y in solid.corners()]
    return [
        [solid.x - solid.radius, solid.y - solid.radius],
        [solid.x + solid.radius, solid.y + solid.radius],
    ]


def laser_scan(ranges: Array, frame: str, stamp: TimeMsg, period: float) -> LaserScan:
    """Make a scan of 360°, counter-clockwise from behind; inf: no obstacle. `period`: s between scans."""
    message = LaserScan()
    message.header.frame_id, message.header.stamp = frame, stamp
    message.angle_min = -math.pi
    message.angle_increment = math.tau / BEAMS
    message.angle_max = message.angle_min + message.angle_increment * (BEAMS - 1)
    message.scan_time = period
    message.range_min, message.range_max = LEAST_RANGE, GREATEST_RANGE
    message.ranges = ranges.astype(np.float32)
    return message
