"""A map of cells, read from a nav_msgs/OccupancyGrid and written as one. Needs numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from builtin_interfaces.msg import Time as TimeMsg
from nav_msgs.msg import OccupancyGrid
from numpy.typing import NDArray

Array = NDArray[np.float64]
Cells = NDArray[np.intp]
Flags = NDArray[np.bool_]

OCCUPIED_FROM = 65  # cell value, 0 to 100: from this on a cell counts as occupied


@dataclass(frozen=True)
class Geometry:
    """The grid of a map: the corner of the first cell (m), the size of a cell (m), rows and columns."""

    x: float
    y: float
    resolution: float
    rows: int
    columns: int

    def cells(self, points: Array) -> Cells:
        """Return the row and column of each of the points (n, 2); they may be off the map."""
        found: Cells = np.floor((points[:, ::-1] - [self.y, self.x]) / self.resolution).astype(np.intp)
        return found

    def inside(self, cells: Cells) -> Flags:
        """Return which of the cells are on the map."""
        row, column = cells[:, 0], cells[:, 1]
        on: Flags = (row >= 0) & (row < self.rows) & (column >= 0) & (column < self.columns)
        return on

    def centres(self, cells: Cells) -> Array:
        """Return the centre of each cell, x and y in m."""
        middle: Array = (cells[:, ::-1] + 0.5) * self.resolution + [self.x, self.y]
        return middle


def read(grid: OccupancyGrid) -> tuple[Geometry, Flags]:
    """Return a map's geometry, and a flag for each cell: occupied or not. Unknown cells count as free.

    Raises ValueError if the data does not fit the map's size, or if the map's origin is rotated.
    """
    info = grid.info
    data = np.asarray(grid.data, dtype=np.int8)
    if info.width * info.height != len(data) or not len(data) or not info.resolution > 0.0:
        size = f'{info.width} x {info.height} cells of {info.resolution} m'
        raise ValueError(f'a map of {size} has {len(data)} values')
    if abs(info.origin.orientation.z) > 1e-6:
        raise ValueError('a turned map is not read: its origin has a heading')
    geometry = Geometry(
        info.origin.position.x, info.origin.position.y, info.resolution, info.height, info.width
    )
    return geometry, data.reshape(info.height, info.width) >= OCCUPIED_FROM


def write(geometry: Geometry, costs: NDArray[np.int8], frame: str, stamp: TimeMsg) -> OccupancyGrid:
    """Return an OccupancyGrid with `costs` from 0 to 100 as its values."""
    message = OccupancyGrid()
    message.header.frame_id, message.header.stamp = frame, stamp
    info = message.info
    info.map_load_time, info.resolution = stamp, geometry.resolution
    info.width, info.height = geometry.columns, geometry.rows
    info.origin.position.x, info.origin.position.y = geometry.x, geometry.y
    info.origin.orientation.w = 1.0
    message.data = costs.reshape(-1)
    return message
