"""CvBridge: converts sensor_msgs/Image and CompressedImage to arrays and back."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from cv_bridge.conversion import Picture, convert, require_opencv
from cv_bridge.encodings import (
    DEPTHS,
    DTYPES,
    ConversionError,
    cv_type,
    depth_and_channels,
    encoding_of,
    getCvType,
)

ValueT = TypeVar('ValueT')

_BY_CHANNELS = {1: 'mono', 3: 'bgr', 4: 'bgra'}
"""The encoding of a decoded picture, without its bits, by the number of channels."""


class CvBridgeError(TypeError):
    """An error if a picture cannot be converted, or its message contradicts itself."""


class CvBridge:
    """Converts pictures. The object has no state: one is enough for a program, and any thread may use it."""

    def __init__(self) -> None:
        """Make `cvtype_to_name` and the other tables that programs read."""
        self.cvtype_to_name = {
            cv_type(depth, channels): f'{depth}C{channels}' for depth in DEPTHS for channels in (1, 2, 3, 4)
        }
        self.cvdepth_to_numpy_depth = {at: DTYPES[depth] for at, depth in enumerate(DEPTHS)}
        self.numpy_type_to_cvtype = {
            **{dtype: depth for depth, dtype in DTYPES.items()},
            **DTYPES,
        }

    # -- types -----------------------------------------------------------------------------------------------

    def dtype_with_channels_to_cvtype2(self, dtype: np.dtype[Any], n_channels: int) -> str:
        """Return the encoding of arrays of a dtype, e.g. '8UC3'; raises CvBridgeError if there is none."""
        depth = self.numpy_type_to_cvtype.get(dtype.name)
        if depth is None:
            raise CvBridgeError(
                f'pictures of {dtype.name} have no encoding: convert it to {", ".join(DTYPES.values())}'
            )
        return f'{depth}C{n_channels}'

    def cvtype2_to_dtype_with_channels(self, cvtype: int) -> tuple[str, int]:
        """Return the name of the dtype and the number of channels of an OpenCV type; raises CvBridgeError."""
        depth, channels = _or_error(lambda: depth_and_channels(cvtype))
        return DTYPES[depth], channels

    def encoding_to_cvtype2(self, encoding: str) -> int:
        """Return OpenCV's type number for an encoding; raises CvBridgeError for an unknown encoding."""
        return _or_error(lambda: getCvType(encoding))

    def encoding_to_dtype_with_channels(self, encoding: str) -> tuple[str, int]:
        """Return the dtype's name and the number of channels of an encoding; raises CvBridgeError."""
        found = _or_error(lambda: encoding_of(encoding))
        return DTYPES[found.depth], found.channels

    # -- pictures --------------------------------------------------------------------------------------------

    def imgmsg_to_cv2(self, img_msg: Image, desired_encoding: str = 'passthrough') -> Picture:
        """Return a picture as a new array of height x width, or height x width x channels.

        If the desired encoding is 'passthrough', the message's encoding is kept. Raises CvBridgeError if the
        message has fewer bytes than the picture's size needs, or if the picture cannot be converted.
        """
        name, channels = self.encoding_to_dtype_with_channels(img_msg.encoding)
        dtype = np.dtype(name).newbyteorder('>' if img_msg.is_bigendian else '<')
        height, width, step = img_msg.height, img_msg.width, img_msg.step
        row = width * channels * dtype.itemsize
        data = np.frombuffer(img_msg.data, np.uint8)
        if step < row or len(data) < step * height:
            raise CvBridgeError(
                f'a picture of {width} x {height} in {img_msg.encoding} has rows of {row} bytes or more, '
                f'but the message has {len(data)} bytes with a step of {step}'
            )
        rows = np.ascontiguousarray(data[: step * height].reshape(height, step)[:, :row])
        shape = (height, width) if channels == 1 else (height, width, channels)
        picture = np.ascontiguousarray(rows.view(dtype).reshape(shape).astype(np.dtype(name)))
        if desired_encoding == 'passthrough':
            return picture
        return _or_error(lambda: convert(picture, img_msg.encoding, desired_encoding))

    def cv2_to_imgmsg(
        self, cvim: Picture, encoding: str = 'passthrough', header: Header | None = None
    ) -> Image:
        """Return an array as a message.

        The array is not converted: `encoding` tells what the array holds; for 'passthrough', the message gets
        an encoding such as '8UC3'. Raises TypeError for anything but an array, CvBridgeError if the array's
        type does not fit the encoding.
        """
        _check_is_array(cvim)
        if cvim.ndim not in {2, 3}:
            raise CvBridgeError(f'a picture has 2 or 3 dimensions, and this array {cvim.ndim}')
        channels = 1 if cvim.ndim == 2 else cvim.shape[2]
        own = self.dtype_with_channels_to_cvtype2(cvim.dtype, channels)
        if encoding != 'passthrough':
            named = _or_error(lambda: encoding_of(encoding))
            if f'{named.depth}C{named.channels}' != own:
                raise CvBridgeError(
                    f'encoding specified as {encoding}, but image has incompatible type {own}'
                )
        message = Image(height=cvim.shape[0], width=cvim.shape[1])
        if header is not None:
            message.header = header
        message.encoding = own if encoding == 'passthrough' else encoding
        message.is_bigendian = cvim.dtype.byteorder == '>' or (cvim.dtype.byteorder, sys.byteorder) == (
            '=',
            'big',
        )
        message.data = cvim.tobytes()
        message.step = cvim.shape[1] * channels * cvim.dtype.itemsize
        return message

    # -- compressed pictures ---------------------------------------------------------------------------------

    def compressed_imgmsg_to_cv2(
        self, cmprs_img_msg: CompressedImage, desired_encoding: str = 'passthrough'
    ) -> Picture:
        """Return a compressed picture as an array; colours are in OpenCV's order: blue, green, red.

        Raises CvBridgeError if the picture cannot be decoded or converted, or if OpenCV is missing.
        """
        cv2 = _or_error(lambda: require_opencv('compressed pictures'))
        data = np.frombuffer(bytes(cmprs_img_msg.data), np.uint8)
        decoded = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if len(data) else None
        if decoded is None:
            raise CvBridgeError(f'{len(data)} bytes of {cmprs_img_msg.format!r} are not a picture')
        picture = np.asarray(decoded)
        if desired_encoding == 'passthrough':
            return picture
        channels = 1 if picture.ndim == 2 else picture.shape[2]
        source = f'{_BY_CHANNELS.get(channels, "")}{picture.dtype.itemsize * 8}'
        return _or_error(lambda: convert(picture, source, desired_encoding))

    def cv2_to_compressed_imgmsg(self, cvim: Picture, dst_format: str = 'jpg') -> CompressedImage:
        """Return an array as a compressed picture; `dst_format` is a file suffix such as 'png'.

        Raises TypeError for anything but an array, CvBridgeError if OpenCV cannot encode it or is missing.
        """
        _check_is_array(cvim)
        cv2 = _or_error(lambda: require_opencv('compressed pictures'))
        try:
            done, data = cv2.imencode(f'.{dst_format}', cvim)
        except cv2.error as error:
            raise CvBridgeError(str(error)) from None
        if not done:
            raise CvBridgeError(f'OpenCV cannot encode this picture as {dst_format}')
        return CompressedImage(format=dst_format, data=data.tobytes())


def _check_is_array(cvim: object) -> None:
    if not isinstance(cvim, np.ndarray | np.generic):
        raise TypeError('Your input type is not a numpy array')


def _or_error(work: Callable[[], ValueT]) -> ValueT:
    """Call `work` and return its result; turn a ConversionError into a CvBridgeError."""
    try:
        return work()
    except ConversionError as error:
        raise CvBridgeError(str(error)) from None
