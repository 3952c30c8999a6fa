"""The names of the encodings in sensor_msgs/Image, and OpenCV's type numbers for these encodings.

The names are those of sensor_msgs/image_encodings.hpp, and the numbers those of cv_bridge's getCvType.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

DEPTHS = ('8U', '8S', '16U', '16S', '32S', '32F', '64F')
"""OpenCV's names of the number types; the index is OpenCV's number of the type."""
DTYPES = {
    '8U': 'uint8',
    '8S': 'int8',
    '16U': 'uint16',
    '16S': 'int16',
    '32S': 'int32',
    '32F': 'float32',
    '64F': 'float64',
}
"""numpy's names of the number types."""
COLOURS = ('rgb', 'bgr', 'rgba', 'bgra')
_YUV = {'yuv422': 'uyvy', 'uyvy': 'uyvy', 'yuv422_yuy2': 'yuyv', 'yuyv': 'yuyv'}
_GENERIC = re.compile(r'(8U|8S|16U|16S|32S|32F|64F)(?:C([1-9][0-9]{0,2}))?')
_MOST_CHANNELS = 512
_CV4_CHANNELS = 8
"""The number that one more channel adds to a type's number in OpenCV 4; OpenCV 5 adds another one."""


class ConversionError(RuntimeError):
    """An error for an unknown encoding or an impossible conversion; CvBridge raises CvBridgeError instead."""


class Encoding(NamedTuple):
    """An encoding's name and its meaning."""

    name: str
    depth: str
    """One of DEPTHS."""
    channels: int
    kind: str
    """The meaning of the channels: 'gray', one of COLOURS, 'uyvy', 'yuyv', or a Bayer pattern such as 'rggb'.

    '' if the name tells only the number of channels.
    """

    @property
    def bits(self) -> int:
        """The number of bits of one value."""
        return int(self.depth[:-1])


@cache
def encoding_of(name: str) -> Encoding:
    """Return the meaning of an encoding's name; raises ConversionError for an unknown name."""
    for depth in ('8', '16'):
        head = name.removesuffix(depth)
        if head == name:
            continue
        if head == 'mono':
            return Encoding(name, f'{depth}U', 1, 'gray')
        if head in COLOURS:
            return Encoding(name, f'{depth}U', len(head), head)
        if head in {'bayer_rggb', 'bayer_bggr', 'bayer_gbrg', 'bayer_grbg'}:
            return Encoding(name, f'{depth}U', 1, head.removeprefix('bayer_'))
    if name in _YUV:
        return Encoding(name, '8U', 2, _YUV[name])
    found = _GENERIC.fullmatch(name)
    channels = int(found[2] or 1) if found else 0
    if found is None or channels > _MOST_CHANNELS:
        raise ConversionError(f'Unrecognized image encoding [{name[:100]}]')
    return Encoding(name, found[1], channels, '')


@cache
def _channel() -> int:
    """Return the number that each further channel adds to a type's number in the installed OpenCV."""
    try:
        import cv2
    except ImportError:
        return _CV4_CHANNELS
    return int(cv2.CV_8UC2 - cv2.CV_8UC1)


def cv_type(depth: str, channels: int) -> int:
    """Return OpenCV's number for a type such as CV_8UC3, given by depth and channels."""
    return DEPTHS.index(depth) + _channel() * (channels - 1)


def depth_and_channels(number: int) -> tuple[str, int]:
    """Return depth and channels of a type number from `cv_type`; raises ConversionError for others."""
    channels, depth = divmod(number, _channel())
    if number < 0 or depth >= len(DEPTHS):
        raise ConversionError(f'{number} is not the number of an OpenCV type')
    return DEPTHS[depth], channels + 1


def getCvType(encoding: str) -> int:
    """Return OpenCV's type number for an encoding; raises RuntimeError for an unknown encoding."""
    found = encoding_of(encoding)
    return cv_type(found.depth, found.channels)
