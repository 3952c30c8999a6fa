"""Layers of the 3D view for a robot's senses: point clouds, cameras, and poses with their uncertainty."""

from __future__ import annotations

import math
from base64 import b64encode
from typing import Any, TypeAlias

import numpy as np

from goalwire.apps.console.state.layers import Drawing, Shape, arrow, pose_of
from goalwire.errors import RemoteError
from goalwire.idl.pictures import pixels
from goalwire.transforms.rigid import Rigid

CLOUD = 'sensor_msgs/msg/PointCloud2'
CAMERA = 'sensor_msgs/msg/CameraInfo'
POSE = 'geometry_msgs/msg/PoseStamped'
POSE_WITH_COVARIANCE = 'geometry_msgs/msg/PoseWithCovarianceStamped'
ODOMETRY = 'nav_msgs/msg/Odometry'

MOST_CLOUD_POINTS = 50_000
MOST_PICTURE_PIXELS = 160
"""The largest side of a picture in the scene, in pixels; larger pictures are thinned out."""
_FLOATS = {7: '<f4', 8: '<f8'}
"""Datatypes of sensor_msgs/msg/PointField that coordinates may have."""
_FLOAT32, _UINT32 = 7, 6
_RAMP = ((40, 70, 200), (20, 160, 170), (120, 190, 60), (240, 180, 40), (220, 60, 40))
"""The colours of heights, from low to high."""
_CAMERA_DEPTH = 0.4
_CAMERA_COLOUR = [0.95, 0.6, 0.1, 1.0]
_POSE_COLOUR = [0.55, 0.3, 0.85, 1.0]
_ELLIPSE = [0.55, 0.3, 0.85, 0.8]
_CORNERS = 48
_SIGMAS = 2.0
"""The ellipse contains the position with 86 %: two standard deviations in the plane."""
_WIDEST_M = 50.0

_Array: TypeAlias = np.ndarray[Any, Any]


# -- point clouds --------------------------------------------------------------------------------------------


def draw_cloud(message: Any) -> Drawing:
    """Return a sensor_msgs/msg/PointCloud2 as points, coloured by its field rgb or else by height.

    Points that are not finite are left out; of more than MOST_CLOUD_POINTS each second, third … is drawn.
    Raises RemoteError for a cloud without x, y and z, or with too little data.
    """
    count = message.width * message.height
    fields = {each.name: each for each in message.fields}
    step = message.point_step
    data = np.frombuffer(memoryview(message.data), np.uint8) if len(message.data) else np.zeros(0, np.uint8)
    if not all(name in fields and fields[name].datatype in _FLOATS for name in 'xyz'):
        raise RemoteError('the cloud has no fields x, y and z of floating-point numbers')
    wide, high = message.row_step, message.height
    if not step or wide < message.width * step or len(data) < wide * high:
        raise RemoteError(f'the cloud should have {count} points of {step} bytes, but has {len(data)} bytes')
    rows = data[: wide * high].reshape(high, wide)[:, : message.width * step]
    every = max(1, -(-count // MOST_CLOUD_POINTS))
    points = rows.reshape(count, step)[::every]
    order = '>' if message.is_bigendian else '<'
    spots = np.stack([_column(points, fields[name], order) for name in 'xyz'], axis=-1)
    is_finite = np.isfinite(spots).all(axis=-1)
    spots = spots[is_finite].astype('<f4')
    colours = _colours_of(points[is_finite], fields, order, spots)
    shape = {
        'kind': 'cloud',
        'spots': b64encode(spots.tobytes()).decode(),
        'colours': b64encode(colours.tobytes()).decode(),
    }
    note = f'{len(spots)} points'
    if every > 1:
        note += f', one of each {every}'
    return Drawing({_frame(message): [shape]}, note)


def _column(points: _Array, field: Any, order: str) -> _Array:
    """Return one field of all points, such as their x."""
    kind = np.dtype(_FLOATS[field.datatype].replace('<', order))
    if field.offset + kind.itemsize > points.shape[1]:
        raise RemoteError(f"the cloud's field {field.name[:40]!r} lies outside of its points")
    part = np.ascontiguousarray(points[:, field.offset : field.offset + kind.itemsize])
    return part.view(kind).reshape(-1).astype(np.float64)


def _colours_of(points: _Array, fields: dict[str, Any], order: str, spots: _Array) -> _Array:
    """Return red, green and blue of each point, as bytes."""
    packed = fields.get('rgb') or fields.get('rgba')
    if packed is not None and packed.datatype in {_FLOAT32, _UINT32} and packed.offset + 4 <= points.shape[1]:
        part = points[:, packed.offset : packed.offset + 3]  # little-endian: blue, green, red
        if order == '>':
            part = points[:, packed.offset + 1 : packed.offset + 4][:, ::-1]
        return np.ascontiguousarray(part[:, ::-1])
    if not len(spots):
        return np.zeros((0, 3), np.uint8)
    low, high = np.percentile(spots[:, 2], (2, 98))
    share = np.clip((spots[:, 2] - low) / max(float(high - low), 1e-6), 0.0, 1.0)
    at = share * (len(_RAMP) - 1)
    parts = zip(*_RAMP, strict=True)
    return np.stack([np.interp(at, range(len(_RAMP)), part) for part in parts], axis=-1).astype(np.uint8)


# -- cameras -------------------------------------------------------------------------------------------------


def draw_camera(message: Any) -> Drawing:
    """Return a sensor_msgs/msg/CameraInfo as the pyramid that the camera sees, in its optical frame.

    Raises RemoteError for a camera that is not calibrated.
    """
    corners = _corners(message)
    spots: list[float] = []
    for corner, following in zip(corners, [*corners[1:], corners[0]], strict=True):
        spots += (0.0, 0.0, 0.0, *corner, *corner, *following)
    shape: Shape = {'kind': 'segments', 'spots': spots, 'rgba': _CAMERA_COLOUR, 'width': 0.01}
    return Drawing({_frame(message): [shape]}, f'{message.width} x {message.height} pixels')


def draw_picture(image: Any, camera: Any) -> Drawing:
    """Return a sensor_msgs/msg/Image at the end of the pyramid of its sensor_msgs/msg/CameraInfo.

    Raises RemoteError for a picture that cannot be shown, or a camera that is not calibrated.
    """
    rows = pixels(image)
    step = max(1, -(-max(rows.shape[:2]) // MOST_PICTURE_PIXELS))
    small = rows[::step, ::step, :3]
    if small.shape[2] != 3:
        small = np.repeat(small[:, :, :1], 3, axis=2)
    shape: Shape = {
        'kind': 'picture',
        'corners': [round(number, 4) for corner in _corners(camera) for number in corner],
        'cells': [small.shape[1], small.shape[0]],
        'pixels': b64encode(np.ascontiguousarray(small).tobytes()).decode(),
    }
    return Drawing({_frame(camera): [shape]}, f'{image.width} x {image.height} pixels')


def _corners(camera: Any) -> list[tuple[float, float, float]]:
    """Return where the corners of a camera's picture lie in its optical frame, from the upper left one on."""
    fx, fy, cx, cy = camera.k[0], camera.k[4], camera.k[2], camera.k[5]
    if not all(map(math.isfinite, (fx, fy, cx, cy))) or fx <= 0 or fy <= 0:
        raise RemoteError('the camera is not calibrated: its focal length is not above 0')
    sides = ((0, 0), (camera.width, 0), (camera.width, camera.height), (0, camera.height))
    found = [((u - cx) / fx * _CAMERA_DEPTH, (v - cy) / fy * _CAMERA_DEPTH, _CAMERA_DEPTH) for u, v in sides]
    if not all(abs(number) < _WIDEST_M for corner in found for number in corner):
        raise RemoteError('the camera is not calibrated: its picture would be wider than 50 m')
    return found


# -- poses ---------------------------------------------------------------------------------------------------


def draw_pose(message: Any) -> Drawing:
    """Return a pose as an arrow on the floor, with an ellipse of two standard deviations if it has them.

    Takes geometry_msgs/msg/PoseStamped, PoseWithCovarianceStamped and nav_msgs/msg/Odometry. Raises
    RemoteError for numbers that are not finite.
    """
    has_covariance = hasattr(message.pose, 'covariance')
    pose = pose_of(message.pose.pose if has_covariance else message.pose)
    shapes = arrow(pose, _POSE_COLOUR)
    if not shapes:
        raise RemoteError('the pose has numbers that are not finite')
    note = ''
    if has_covariance:
        covariance = np.asarray(message.pose.covariance, np.float64).reshape(6, 6)
        ellipse, note = _ellipse(covariance[:2, :2], pose)
        shapes += ellipse
        turn = math.degrees(math.sqrt(max(float(covariance[5, 5]), 0.0)))
        note += f', ±{_SIGMAS * turn:.1f}°' if ellipse and math.isfinite(turn) else ''
    return Drawing({_frame(message): shapes}, note or 'a pose')


def _ellipse(covariance: _Array, pose: Rigid) -> tuple[list[Shape], str]:
    """Return the ellipse of a covariance in the plane (m²), and its size as a text."""
    if not np.isfinite(covariance).all() or not covariance.any():
        return [], 'without covariance'
    spread, axes = np.linalg.eigh((covariance + covariance.T) / 2.0)
    halves = _SIGMAS * np.sqrt(np.maximum(spread, 0.0))
    turns = np.linspace(0.0, math.tau, _CORNERS + 1)
    rim = (axes * np.minimum(halves, _WIDEST_M)) @ np.stack((np.cos(turns), np.sin(turns)))
    x, y, z = pose.translation
    spots = np.stack((rim[0] + x, rim[1] + y, np.full(len(turns), z + 0.02)), axis=-1)
    shape: Shape = {
        'kind': 'line', 'spots': spots.round(3).ravel().tolist(), 'rgba': _ELLIPSE, 'width': 0.015
    }  # fmt: skip
    return [shape], f'±{halves.max():.2f} m'


def _frame(message: Any) -> str:
    return str(message.header.frame_id).lstrip('/')
