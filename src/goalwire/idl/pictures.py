"""Turns images of sensor_msgs into pictures for browsers: raw images into PNG; JPEG and PNG stay as they are.

Imported where a picture is shown: in a notebook, and on the console's page.
"""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np

from goalwire.errors import RemoteError
from goalwire.idl.png import png

IMAGE = 'sensor_msgs/msg/Image'
COMPRESSED = 'sensor_msgs/msg/CompressedImage'
_WIDEST = 640
"""The largest width in pixels; of a wider picture only each second (third, …) pixel is shown."""
_MOST_COMPRESSED = 4 << 20
_CHANNELS = {'rgb8': 3, 'bgr8': 3, 'rgba8': 4, 'bgra8': 4, 'mono8': 1, '8UC1': 1, '8UC3': 3}
PNG, JPEG = 'image/png', 'image/jpeg'
_MAGIC = {b'\x89PNG\r\n\x1a\n': PNG, b'\xff\xd8\xff': JPEG}


def as_data_url(message: Any) -> str:
    """Return an Image or CompressedImage as a data: URL, which contains the picture. Raises RemoteError."""
    kind, data = as_file(message)
    return f'data:{kind};base64,{b64encode(data).decode()}'


def as_file(message: Any) -> tuple[str, bytes]:
    """Return the media type and the file's bytes for an Image or CompressedImage. Raises RemoteError."""
    if not hasattr(message, 'format'):
        return PNG, png(pixels(message))
    data = bytes(message.data)
    for magic, kind in _MAGIC.items():
        if data.startswith(magic) and len(data) <= _MOST_COMPRESSED:
            return kind, data
    raise RemoteError('only JPEG and PNG pictures of up to 4 MB are shown')


def pixels(message: Any) -> np.ndarray[Any, Any]:
    """Return an Image's pixels as bytes, height x width x channels, in the order red, green, blue.

    Wide pictures are thinned out. Raises RemoteError.
    """
    height, width, step, encoding = message.height, message.width, message.step, message.encoding
    data = np.frombuffer(message.data, np.uint8)
    if encoding in {'mono16', '16UC1', '32FC1'}:
        size, dtype = (4, np.float32) if encoding == '32FC1' else (2, np.uint16)
        kind = (
            np.dtype(dtype).newbyteorder('>') if message.is_bigendian else np.dtype(dtype).newbyteorder('<')
        )
        depth = _rows(data, height, width * size, step).reshape(-1).view(kind)
        thinned = depth.reshape(height, width)[:: _skip(width), :: _skip(width)]
        return _stretch(thinned.astype(np.float64))[:, :, None]
    channels = _CHANNELS.get(encoding)
    if channels is None:
        raise RemoteError(f'pictures in {encoding[:40]!r} are not shown')
    rows = _rows(data, height, width * channels, step).reshape(height, width, channels)
    rows = rows[:: _skip(width), :: _skip(width)]
    if encoding.startswith('bgr'):
        rows = rows[:, :, [2, 1, 0, *range(3, channels)]]
    return rows


def _skip(width: int) -> int:
    return max(1, -(-width // _WIDEST))


def _rows(data: np.ndarray[Any, Any], height: int, row: int, step: int) -> np.ndarray[Any, Any]:
    step = step or row
    if not height or not row or step < row or len(data) < step * height:
        raise RemoteError('the picture has fewer bytes than its size needs')
    return np.ascontiguousarray(data[: step * height].reshape(height, step)[:, :row])


def _stretch(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return depths as grey values, the nearest white; missing measurements are black."""
    known = np.isfinite(values) & (values > 0)
    if not known.any():
        return np.zeros(values.shape, np.uint8)
    low, high = float(values[known].min()), float(values[known].max())
    spread = (np.where(known, values, low) - low) / ((high - low) or 1.0)
    return np.where(known, 255 - spread * 215, 0).astype(np.uint8)
