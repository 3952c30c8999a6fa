"""sensor_msgs_py.point_cloud2: converts sensor_msgs/PointCloud2 to numpy arrays and back.

Points are structured arrays: one record for each point, with the names and types of the cloud's fields.
"""

from __future__ import annotations

import sys
from array import array
from collections import namedtuple
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.lib.recfunctions import structured_to_unstructured, unstructured_to_structured
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

__all__ = [
    'DUMMY_FIELD_PREFIX',
    'create_cloud',
    'create_cloud_xyz32',
    'dtype_from_fields',
    'read_points',
    'read_points_list',
    'read_points_numpy',
]

DUMMY_FIELD_PREFIX = 'unnamed_field'

NDArray: TypeAlias = np.ndarray[Any, np.dtype[Any]]

_DATATYPES: dict[int, np.dtype[Any]] = {
    PointField.INT8: np.dtype(np.int8),
    PointField.UINT8: np.dtype(np.uint8),
    PointField.INT16: np.dtype(np.int16),
    PointField.UINT16: np.dtype(np.uint16),
    PointField.INT32: np.dtype(np.int32),
    PointField.UINT32: np.dtype(np.uint32),
    PointField.FLOAT32: np.dtype(np.float32),
    PointField.FLOAT64: np.dtype(np.float64),
}


def read_points(
    cloud: PointCloud2,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[int] | None = None,
    reshape_organized_cloud: bool = False,
) -> NDArray:
    """Return the points as a structured array of shape (N,): a view of the cloud's data where possible.

    `field_names` selects fields; `skip_nans` drops points with a NaN in a selected field, unless the cloud is
    dense; `uvs` selects points by their index; `reshape_organized_cloud` gives an organized cloud the shape
    (width, height), as ROS 2 does, which does not keep the rows: for rows, reshape the result to (height,
    width). Raises AssertionError for anything but a cloud, and for unknown or repeated field names.
    """
    _require(isinstance(cloud, PointCloud2), 'Cloud is not a sensor_msgs.msg.PointCloud2')
    points = _records(cloud)
    if field_names is not None:
        known = points.dtype.names or ()
        unknown = [name for name in field_names if name not in known]
        _require(not unknown, f'{unknown} are no fields of the cloud: it has {list(known)}')
        points = points[list(field_names)]
    if skip_nans and not cloud.is_dense:
        points = points[~_has_nan(points)]
    if uvs is not None:
        points = points[uvs if isinstance(uvs, np.ndarray) else np.fromiter(uvs, int)]
    if reshape_organized_cloud and cloud.height > 1:
        points = points.reshape(cloud.width, cloud.height)
    return points


def read_points_numpy(
    cloud: PointCloud2,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[int] | None = None,
    reshape_organized_cloud: bool = False,
) -> NDArray:
    """Return the points as an array of shape (N, fields); raises AssertionError if field types differ.

    The arguments are those of read_points.
    """
    points = read_points(cloud, field_names, skip_nans, uvs, reshape_organized_cloud)
    types = {points.dtype[name] for name in points.dtype.names or ()}
    _require(len(types) <= 1, 'All fields need to have the same datatype. Use read_points() otherwise.')
    return structured_to_unstructured(points)


def read_points_list(
    cloud: PointCloud2,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[int] | None = None,
) -> list[tuple[Any, ...]]:
    """Return the points as named tuples. The arguments are those of read_points, which is much faster."""
    points = read_points(cloud, field_names, skip_nans, uvs)
    point_type = namedtuple('Point', points.dtype.names or ())  # type: ignore[misc]  # noqa: PYI024 - its names are data
    return [point_type._make(point) for point in points]


def dtype_from_fields(fields: Iterable[PointField], point_step: int | None = None) -> np.dtype[Any]:
    """Return the dtype of a point's record; `point_step`, if given, is the record's size in bytes.

    A field with several values becomes several fields name_0, name_1, …; a field without a name becomes
    unnamed_field_<index>. Raises AssertionError for a repeated name, a count of 0 or an unknown datatype.
    """
    names: list[str] = []
    formats: list[str] = []
    offsets: list[int] = []
    for index, field in enumerate(fields):
        name = field.name or f'{DUMMY_FIELD_PREFIX}_{index}'
        _require(field.datatype in _DATATYPES, f'field {name}: there is no datatype {field.datatype}')
        _require(field.count > 0, f"field {name}: Can't process fields with count = 0.")
        datatype = _DATATYPES[field.datatype]
        for item in range(field.count):
            own = name if field.count == 1 else f'{name}_{item}'
            _require(own not in names, f'Duplicate field names are not allowed! ({own})')
            names.append(own)
            formats.append(datatype.str)
            offsets.append(field.offset + item * datatype.itemsize)
    if point_step is None:
        return np.dtype({'names': names, 'formats': formats, 'offsets': offsets})
    return np.dtype({'names': names, 'formats': formats, 'offsets': offsets, 'itemsize': point_step})


def create_cloud(
    header: Header, fields: Sequence[PointField], points: Iterable[Any], step: int | None = None
) -> PointCloud2:
    """Return a cloud of points: an array of shape (N, fields), a structured array, or a sequence of tuples.

    As in ROS 2, an array with one more dimension makes an organized cloud: (width, height, fields), or
    (width, height) of records. The cloud has the points in the order of the array. `step` is the size of a
    point in bytes; by default it is as small as the fields allow. Raises AssertionError for points that do
    not fit the fields.
    """
    records = _as_records(fields, points, dtype_from_fields(fields, step))
    _require(
        records.ndim in (1, 2), f'Too many dimensions for organized cloud! Points have shape {records.shape}'
    )
    width, height = records.shape if records.ndim == 2 else (records.shape[0], 1)
    return PointCloud2(
        header=header,
        height=height,
        width=width,
        fields=fields,
        is_bigendian=sys.byteorder != 'little',
        is_dense=False,
        point_step=records.dtype.itemsize,
        row_step=records.dtype.itemsize * width,
        data=array('B', records.tobytes()),
    )


def create_cloud_xyz32(header: Header, points: Iterable[Any], step: int | None = None) -> PointCloud2:
    """Return a cloud of points (x, y, z), stored as float32."""
    fields = [
        PointField(name=name, offset=4 * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate('xyz')
    ]
    return create_cloud(header, fields, points, step)


def _records(cloud: PointCloud2) -> NDArray:
    """Return all points in the machine's byte order, copied if rows are padded or the order differs."""
    dtype = dtype_from_fields(cloud.fields, cloud.point_step)
    swapped = cloud.is_bigendian != (sys.byteorder != 'little')
    row = max(cloud.row_step, cloud.width * cloud.point_step)
    records: NDArray = np.ndarray(
        shape=(cloud.height, cloud.width),
        dtype=dtype.newbyteorder() if swapped else dtype,
        buffer=cloud.data,
        strides=(row, cloud.point_step),
    ).reshape(-1)
    return records.astype(dtype) if swapped else records


def _has_nan(points: NDArray) -> np.ndarray[Any, np.dtype[np.bool_]]:
    found = np.zeros(len(points), dtype=bool)
    for name in points.dtype.names or ():
        found |= np.isnan(points[name])
    return found


def _as_records(fields: Sequence[PointField], points: Iterable[Any], dtype: np.dtype[Any]) -> NDArray:
    if not isinstance(points, np.ndarray):
        return np.array([tuple(point) for point in points], dtype=dtype)
    if points.dtype.names is None:
        _require(
            len({field.datatype for field in fields}) <= 1,
            'All fields need to have the same datatype. Pass a structured NumPy array otherwise.',
        )
        return unstructured_to_structured(points, dtype=dtype)
    _require(points.dtype == dtype, f'the points are records of {points.dtype}, the fields ask for {dtype}')
    return points


def _require(condition: bool, problem: str) -> None:
    """Raise ROS 2's AssertionError unless `condition` is true; unlike `assert`, also under python -O."""
    if not condition:
        raise AssertionError(problem)
