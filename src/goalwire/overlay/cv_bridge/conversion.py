"""Converts pictures from one encoding to another: colours and depths.

The rules are those of cv_bridge (toCvCopy), and the arithmetic is OpenCV's.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, TypeAlias

import numpy as np

from cv_bridge.encodings import COLOURS, DTYPES, ConversionError, Encoding, encoding_of

Picture: TypeAlias = np.ndarray[Any, np.dtype[Any]]
"""Height x width, or height x width x channels."""

_GRAY_OF = {'r': 9798, 'g': 19235, 'b': 3735}
_GRAY_BITS = 15
"""Brightness is 0.299 red + 0.587 green + 0.114 blue, as integers in OpenCV's scale (2**15)."""
_BAYER = {'rggb': 'BG', 'bggr': 'RG', 'gbrg': 'GR', 'grbg': 'GB'}
"""OpenCV names a Bayer pattern by pixels 2 and 3 of its second row, ROS by the pixels of two rows."""


def require_opencv(what: str) -> ModuleType:
    """Return OpenCV; raises ConversionError, which names the package to install for `what`."""
    try:
        import cv2
    except ImportError:
        raise ConversionError(f'{what} need OpenCV: pip install opencv-python-headless') from None
    return cv2  # type: ignore[no-any-return, unused-ignore]


def convert(picture: Picture, source: str, target: str) -> Picture:
    """Return a copy of a picture in another encoding; raises ConversionError if there is no such conversion.

    A result with one channel has the shape (height, width). Values are scaled only between 8 and 16 bits; for
    other depths they are rounded and clipped.
    """
    if target in {'', source}:
        return picture.copy()
    before, after = encoding_of(source), encoding_of(target)
    _check(before, after)
    converted = picture
    if before.kind != after.kind and before.kind and after.kind:
        converted = _recolour(converted, before.kind, after.kind)
    if before.depth != after.depth:
        converted = _rescale(converted, before, after)
    return picture.copy() if converted is picture else converted


def _check(before: Encoding, after: Encoding) -> None:
    """Raise ConversionError if one encoding cannot be converted to the other."""
    if after.kind and not before.kind:
        raise ConversionError(
            f'[{before.name}] is not a color format. but [{after.name}] is. '
            'The conversion does not make sense'
        )
    if not (before.kind and after.kind):
        if before.channels != after.channels:
            raise ConversionError(
                f'[{before.name}] and [{after.name}] do not have the same number of channels'
            )
        return
    targets = {'gray', *COLOURS}
    if before.kind in _BAYER:
        targets = {'gray', 'rgb', 'bgr'}
    if after.kind not in targets:
        raise ConversionError(f'Unsupported conversion from [{before.name}] to [{after.name}]')


def _recolour(picture: Picture, before: str, after: str) -> Picture:
    if before in _BAYER or before in {'uyvy', 'yuyv'}:
        return _by_opencv(picture, before, after)
    if after == 'gray':
        return _brightness(picture, before)
    opaque = np.full(picture.shape[:2], np.iinfo(picture.dtype).max, picture.dtype)
    channels = {'a': opaque}
    if before == 'gray':
        channels |= dict.fromkeys('rgb', picture.reshape(picture.shape[:2]))
    else:
        channels |= {name: picture[:, :, at] for at, name in enumerate(before)}
    return np.stack([channels[name] for name in after], axis=2)


def _brightness(picture: Picture, before: str) -> Picture:
    total = np.full(picture.shape[:2], 1 << (_GRAY_BITS - 1), np.uint32)
    for name, weight in _GRAY_OF.items():
        total += picture[:, :, before.index(name)].astype(np.uint32) * np.uint32(weight)
    gray: Picture = (total >> _GRAY_BITS).astype(picture.dtype)
    return gray


def _by_opencv(picture: Picture, before: str, after: str) -> Picture:
    name = after.upper()
    if before in _BAYER:
        cv2 = require_opencv('Bayer patterns')
        code = f'COLOR_Bayer{_BAYER[before]}2{name}'
    else:
        cv2 = require_opencv('pictures in YUV')
        code = f'COLOR_YUV2{name}_{ {"uyvy": "UYVY", "yuyv": "YUY2"}[before] }'
    try:
        return np.asarray(cv2.cvtColor(picture, getattr(cv2, code)))
    except cv2.error as error:
        raise ConversionError(str(error)) from None


def _rescale(picture: Picture, before: Encoding, after: Encoding) -> Picture:
    """Return a picture whose values have the depth of the target encoding."""
    dtype = np.dtype(DTYPES[after.depth])
    if dtype.kind == 'f':
        return picture.astype(dtype)
    scale = {(8, 16): 65535 / 255, (16, 8): 255 / 65535}.get((before.bits, after.bits), 1.0)
    limits = np.iinfo(dtype)
    scaled = np.rint(picture.astype(np.float64) * scale)
    bounded: Picture = np.clip(np.nan_to_num(scaled), limits.min, limits.max).astype(dtype)
    return bounded
