"""Pictures of a bag as files: a folder for each topic, and the time of each picture as its name.

Compressed pictures are written as they are. Others become PNG, with all their bits.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from cv_bridge import CvBridge, CvBridgeError
from cv_bridge.encodings import encoding_of

from goalwire.apps.bag.exporting.folders import Written, file_stems, new_folder
from goalwire.errors import peer_text
from goalwire.idl.png import png
from goalwire.rosbag2.reader import Reader

IMAGE = 'sensor_msgs/msg/Image'
COMPRESSED = 'sensor_msgs/msg/CompressedImage'
_MAGIC = {
    b'\xff\xd8\xff': 'jpg',
    b'\x89PNG\r\n\x1a\n': 'png',
    b'BM': 'bmp',
    b'II*\0': 'tiff',
    b'MM\0*': 'tiff',
}
"""The suffixes of picture files by the first bytes of their format."""
_DEPTH_HEADER = 12
"""Bytes before the PNG in a picture that image_transport's compressedDepth made."""
_BY_OPENCV = {1: 'gray', 3: 'bgr', 4: 'bgra'}
"""The encodings assumed for pictures that only say how many channels they have."""


def write_pictures(bag: Reader, topics: Collection[str], start: int, folder: Path) -> list[Written]:
    """Write the pictures of `topics` that were recorded at `start` (in ns) or later.

    All messages of `topics` must be pictures. A file's name is the time of recording in ns, with .png or
    .jpg. Raises BagError, DecodeError, OSError.
    """
    stems = file_stems(topics)
    new_folder(folder)
    counts: Counter[str] = Counter()
    reasons: dict[str, Counter[str]] = {topic: Counter() for topic in topics}
    for message, picture in bag.decoded(topics, start):
        place = folder / stems[message.topic]
        try:
            suffix, data = file_of(picture)
        except ValueError as error:
            reasons[message.topic][str(error)] += 1
            continue
        if not counts[message.topic]:
            place.mkdir()
        _free_path(place, message.time, suffix).write_bytes(data)
        counts[message.topic] += 1
    return [
        Written(
            folder / stems[topic],
            counts[topic],
            tuple(f'{count:,} pictures are left out: {reason}' for reason, count in reasons[topic].items()),
        )
        for topic in topics
        if counts[topic] or reasons[topic]
    ]


def _free_path(folder: Path, time: int, suffix: str) -> Path:
    path, number = folder / f'{time}.{suffix}', 2
    while path.exists():
        path, number = folder / f'{time}_{number}.{suffix}', number + 1
    return path


def file_of(message: Any) -> tuple[str, bytes]:
    """Return the suffix and the bytes of a picture's file; raises ValueError for an unusable picture."""
    if hasattr(message, 'format'):
        return _read_compressed(bytes(message.data), message.format)
    try:
        return 'png', png(pixels_of(message))
    except CvBridgeError as error:
        raise ValueError(peer_text(error)) from None


def _read_compressed(data: bytes, stated: str) -> tuple[str, bytes]:
    if 'compressedDepth' in stated:
        if not stated.startswith('16UC1'):
            raise ValueError(f'{peer_text(stated, 60)}: depths of this format are not written')
        data = data[_DEPTH_HEADER:]
    for magic, suffix in _MAGIC.items():
        if data.startswith(magic):
            return suffix, data
    if data[:4] == b'RIFF' and data[8:12] == b'WEBP':
        return 'webp', data
    raise ValueError(f'{peer_text(stated, 60)!r} is not a picture format that can be written to a file')


def pixels_of(message: Any) -> np.ndarray[Any, Any]:
    """Return height x width x channels, colours as red, green, blue. Raises CvBridgeError, ValueError."""
    bridge = CvBridge()
    picture = bridge.imgmsg_to_cv2(message)
    encoding = encoding_of(message.encoding)
    if not picture.size:
        raise ValueError('the pictures have no pixels: width or height is 0')
    if encoding.depth not in {'8U', '16U'}:
        raise ValueError(f'PNG cannot hold the numbers of {encoding.name}')
    kind = encoding.kind or _BY_OPENCV.get(encoding.channels, '')
    if not kind:
        raise ValueError(f'PNG cannot hold pictures with {encoding.channels} channels')
    if kind not in {'gray', 'rgb', 'bgr', 'rgba', 'bgra'}:
        return bridge.imgmsg_to_cv2(message, f'rgb{encoding.bits}')
    if kind.startswith('bgr'):
        picture = picture[:, :, [2, 1, 0, *range(3, encoding.channels)]]
    return picture.reshape(*picture.shape[:2], encoding.channels)
