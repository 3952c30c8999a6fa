"""Pictures of messages as pixels in red, green and blue, 8 bits each, as cameras of a dataset have them."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from cv_bridge import CvBridgeError
from cv_bridge.encodings import encoding_of

from goalwire.apps.bag.exporting.pictures import file_of, pixels_of
from goalwire.errors import BagError, peer_text


def colours_of(message: Any) -> np.ndarray[Any, Any]:
    """Return the pixels of an Image or a CompressedImage: height x width x 3 of uint8.

    Raises ValueError for a picture that has other numbers, such as depths, and for a broken one. Raises
    BagError if Pillow is missing, which unpacks compressed pictures.
    """
    if hasattr(message, 'format'):
        return _unpack(message)
    try:
        if encoding_of(message.encoding).depth != '8U':
            raise ValueError(f'{peer_text(message.encoding, 60)} has no colours of 8 bits')
        pixels = pixels_of(message)
    except CvBridgeError as error:
        raise ValueError(peer_text(error)) from None
    if pixels.shape[2] == 1:
        pixels = np.repeat(pixels, 3, axis=2)
    return np.ascontiguousarray(pixels[:, :, :3])


def _unpack(message: Any) -> np.ndarray[Any, Any]:
    suffix, data = file_of(message)
    try:
        from PIL import Image
    except ModuleNotFoundError:
        raise BagError("compressed pictures need the package 'pillow'; run: pip install pillow") from None
    try:
        with Image.open(io.BytesIO(data)) as picture:
            if picture.mode not in {'1', 'L', 'LA', 'P', 'RGB', 'RGBA', 'CMYK', 'YCbCr'}:
                raise ValueError(f'a {suffix} picture of the mode {picture.mode} has no colours of 8 bits')
            return np.asarray(picture.convert('RGB'))
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f'a {suffix} picture is broken: {peer_text(error, 200)}') from None
