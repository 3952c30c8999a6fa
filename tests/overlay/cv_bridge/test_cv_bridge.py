"""cv_bridge: messages to arrays and back, with numpy alone, and as OpenCV does it where that is installed."""

from __future__ import annotations

import sys
from typing import Any

import cv_bridge
import numpy as np
import pytest
from cv_bridge import CvBridge, CvBridgeError, cvtColorForDisplay, getCvType
from cv_bridge.boost import cv_bridge_boost
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

Picture = np.ndarray[Any, np.dtype[Any]]
BRIDGE = CvBridge()
RANDOM = np.random.default_rng(7)
COLOURS = {'rgb': 3, 'bgr': 3, 'rgba': 4, 'bgra': 4}
BAYER = ['bayer_rggb', 'bayer_bggr', 'bayer_gbrg', 'bayer_grbg']


def noise(*shape: int, dtype: str = 'uint8') -> Picture:
    return RANDOM.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


def message(encoding: str, data: bytes, width: int, height: int, step: int, *, big: bool = False) -> Image:
    return Image(encoding=encoding, data=data, width=width, height=height, step=step, is_bigendian=big)


@pytest.fixture
def without_opencv(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'cv2', None)


# -- as they are ---------------------------------------------------------------------------------------------


@pytest.mark.usefixtures('without_opencv')
@pytest.mark.parametrize('dtype', ['uint8', 'int8', 'uint16', 'int16', 'int32', 'float32', 'float64'])
@pytest.mark.parametrize('channels', [None, 1, 2, 3, 4, 5])
def test_arrays_come_back_as_they_were(dtype: str, channels: int | None) -> None:
    picture = noise(7, 11, *([] if channels is None else [channels])).astype(dtype)
    sent = BRIDGE.cv2_to_imgmsg(picture, header=Header(frame_id='camera'))
    assert (sent.height, sent.width, sent.header.frame_id) == (7, 11, 'camera')
    assert sent.step == 11 * (channels or 1) * picture.itemsize
    back = BRIDGE.imgmsg_to_cv2(sent)
    assert (back.dtype, back.flags.writeable, back.flags.c_contiguous) == (picture.dtype, True, True)
    assert (back == (picture[:, :, 0] if channels == 1 else picture)).all()


def test_a_slice_of_an_array_is_sent_as_it_looks() -> None:
    picture = noise(8, 10, 3)[1:7:2, ::-1]
    assert (BRIDGE.imgmsg_to_cv2(BRIDGE.cv2_to_imgmsg(picture, 'bgr8')) == picture).all()


def test_rows_may_have_bytes_behind_their_pixels() -> None:
    rows = noise(4, 10)
    assert (
        BRIDGE.imgmsg_to_cv2(message('rgb8', rows.tobytes(), 3, 4, 10)) == rows[:, :9].reshape(4, 3, 3)
    ).all()


@pytest.mark.parametrize('order', ['<', '>'])
def test_numbers_of_either_byte_order_are_read(order: str) -> None:
    depths = noise(3, 4, dtype='uint16').astype(f'{order}u2')
    sent = BRIDGE.cv2_to_imgmsg(depths, 'mono16')
    assert sent.is_bigendian is (order == '>')
    back = BRIDGE.imgmsg_to_cv2(sent)
    assert back.dtype.isnative
    assert (back == depths).all()


@pytest.mark.parametrize(
    ('sent', 'said'),
    [
        (message('rgb8', bytes(11), 2, 2, 6), '11 bytes with a step of 6'),
        (message('rgb8', bytes(12), 2, 2, 5), 'step of 5'),
        (message('rainbow', b'', 0, 0, 0), r'Unrecognized image encoding \[rainbow\]'),
        (message('8UC0', b'', 0, 0, 0), 'Unrecognized'),
        (message('8UC999', b'', 0, 0, 0), 'Unrecognized'),
    ],
)
def test_a_message_that_contradicts_itself_is_refused(sent: Image, said: str) -> None:
    with pytest.raises(CvBridgeError, match=said):
        BRIDGE.imgmsg_to_cv2(sent)


def test_an_encoding_that_the_array_has_not_is_refused() -> None:
    with pytest.raises(CvBridgeError, match='rgba8, but image has incompatible type 8UC3'):
        BRIDGE.cv2_to_imgmsg(noise(2, 2, 3), 'rgba8')
    with pytest.raises(CvBridgeError, match='int64 have no encoding'):
        BRIDGE.cv2_to_imgmsg(np.zeros((2, 2), 'int64'))
    with pytest.raises(CvBridgeError, match='this array 1'):
        BRIDGE.cv2_to_imgmsg(np.zeros(4, 'uint8'))
    with pytest.raises(TypeError, match='not a numpy array'):
        BRIDGE.cv2_to_imgmsg([[1]])  # type: ignore[arg-type]


# -- colours and depths --------------------------------------------------------------------------------------


def converted(picture: Picture, source: str, target: str) -> Picture:
    return BRIDGE.imgmsg_to_cv2(BRIDGE.cv2_to_imgmsg(picture, source), target)


@pytest.mark.usefixtures('without_opencv')
@pytest.mark.parametrize('depth', ['8', '16'])
@pytest.mark.parametrize('source', COLOURS)
@pytest.mark.parametrize('target', [*COLOURS, 'mono'])
def test_colours_are_those_of_opencv(
    source: str, target: str, depth: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = noise(16, 16, COLOURS[source], dtype=f'uint{depth}')
    found = converted(picture, source + depth, target + depth)
    monkeypatch.undo()
    cv2 = pytest.importorskip('cv2')
    if source == target:
        expected = picture
    else:
        to = 'GRAY' if target == 'mono' else target.upper()
        expected = cv2.cvtColor(picture, getattr(cv2, f'COLOR_{source.upper()}2{to}'))
    assert (found == expected).all()


@pytest.mark.usefixtures('without_opencv')
def test_gray_becomes_colours_that_are_opaque() -> None:
    picture = noise(3, 4)
    found = converted(picture, 'mono8', 'bgra8')
    assert (found[..., :3] == picture[..., None]).all()
    assert (found[..., 3] == 255).all()


@pytest.mark.usefixtures('without_opencv')
@pytest.mark.parametrize(
    ('value', 'source', 'target', 'expected'),
    [
        (255, 'mono8', 'mono16', 65535),
        (1, 'mono8', 'mono16', 257),
        (65535, 'mono16', 'mono8', 255),
        (128, 'mono16', 'mono8', 0),
        (129, 'mono16', 'mono8', 1),
        (300.5, '32FC1', '8UC1', 255),
        (-3.0, '32FC1', '16UC1', 0),
        (2.5, '32FC1', '8UC1', 2),
        (7, '16UC1', '32FC1', 7.0),
    ],
)
def test_only_8_and_16_bits_are_scaled(value: float, source: str, target: str, expected: float) -> None:
    dtype, _ = BRIDGE.encoding_to_dtype_with_channels(source)
    found = converted(np.full((1, 1), value, dtype), source, target)
    assert found.tolist() == [[expected]]


def test_colour_and_depth_change_together() -> None:
    found = converted(noise(4, 4, 3), 'rgb8', 'mono16')
    assert (found.shape, found.dtype.name) == ((4, 4), 'uint16')
    assert (found % 257 == 0).all()


@pytest.mark.parametrize('pattern', BAYER)
@pytest.mark.parametrize('depth', ['8', '16'])
def test_bayer_patterns_keep_a_plain_colour(pattern: str, depth: str) -> None:
    """A red surface is red, whatever the pattern begins with."""
    pytest.importorskip('cv2')
    most = 2 ** int(depth) - 1
    tile = np.array([most if letter == 'r' else 0 for letter in pattern.removeprefix('bayer_')]).reshape(2, 2)
    picture = np.tile(tile, (4, 4)).astype(f'uint{depth}')
    found = converted(picture, pattern + depth, f'rgb{depth}')
    assert (found[2:-2, 2:-2] == [most, 0, 0]).all()


def test_yuv_422_has_the_order_that_its_name_says() -> None:
    pytest.importorskip('cv2')
    uyvy = np.tile(np.array([[[128, 235], [128, 235]]], np.uint8), (2, 1, 1))
    assert (converted(uyvy, 'yuv422', 'rgb8') == 255).all()
    assert (converted(uyvy[:, :, ::-1].copy(), 'yuv422_yuy2', 'rgb8') == 255).all()


@pytest.mark.usefixtures('without_opencv')
@pytest.mark.parametrize(('source', 'shape'), [('bayer_rggb8', (2, 2)), ('yuv422', (2, 2, 2))])
def test_without_opencv_it_says_what_to_install(source: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(CvBridgeError, match='pip install opencv-python-headless'):
        converted(np.zeros(shape, 'uint8'), source, 'rgb8')
    with pytest.raises(CvBridgeError, match='compressed pictures need OpenCV'):
        BRIDGE.compressed_imgmsg_to_cv2(CompressedImage(format='png', data=b'x'))


@pytest.mark.parametrize(
    ('source', 'target', 'said'),
    [
        ('8UC3', 'mono16', r'\[8UC3\] is not a color format'),
        ('8UC3', '8UC1', 'same number of channels'),
        ('rgb8', '8UC1', 'same number of channels'),
        ('rgb8', 'bayer_rggb8', 'Unsupported conversion'),
        ('rgb8', 'rainbow', 'Unrecognized'),
    ],
)
def test_conversions_without_sense_are_refused(source: str, target: str, said: str) -> None:
    with pytest.raises(CvBridgeError, match=said):
        converted(noise(2, 2, 3), source, target)


def test_what_is_asked_for_is_a_copy() -> None:
    sent = BRIDGE.cv2_to_imgmsg(noise(2, 2, 3), 'rgb8')
    before = bytes(sent.data)
    for encoding in ('passthrough', 'rgb8', '8UC3', 'bgr8'):
        BRIDGE.imgmsg_to_cv2(sent, encoding)[:] = 0
    assert bytes(sent.data) == before


# -- compressed pictures -------------------------------------------------------------------------------------


@pytest.mark.parametrize('shape', [(6, 8), (6, 8, 3), (6, 8, 4)])
@pytest.mark.parametrize('dtype', ['uint8', 'uint16'])
def test_a_png_comes_back_as_it_was(shape: tuple[int, ...], dtype: str) -> None:
    pytest.importorskip('cv2')
    picture = noise(*shape, dtype=dtype)
    sent = BRIDGE.cv2_to_compressed_imgmsg(picture, 'png')
    assert (sent.format, bytes(sent.data[1:4])) == ('png', b'PNG')
    assert (BRIDGE.compressed_imgmsg_to_cv2(sent) == picture).all()
    mono = BRIDGE.compressed_imgmsg_to_cv2(sent, 'mono8')
    assert (mono.shape, mono.dtype.name) == ((6, 8), 'uint8')


def test_what_cannot_be_compressed_is_told() -> None:
    pytest.importorskip('cv2')
    with pytest.raises(CvBridgeError):
        BRIDGE.cv2_to_compressed_imgmsg(noise(2, 2), 'no_format')
    with pytest.raises(CvBridgeError, match=r'4 bytes of .* are not a picture'):
        BRIDGE.compressed_imgmsg_to_cv2(CompressedImage(format='jpeg', data=b'\0\1\2\3'))
    with pytest.raises(CvBridgeError, match='0 bytes'):
        BRIDGE.compressed_imgmsg_to_cv2(CompressedImage())


# -- for people ----------------------------------------------------------------------------------------------


def test_each_label_has_a_colour_and_0_is_black() -> None:
    labels = np.arange(12, dtype=np.int32).reshape(3, 4)
    shown = cvtColorForDisplay(labels, '32SC1', 'bgr8')
    assert (shown.shape, shown.dtype.name) == ((3, 4, 3), 'uint8')
    assert (shown[0, 0] == 0).all()
    assert shown[0, 1].tolist() == [214, 235, 249]  # blue, green, red of the second colour by the alphabet


def test_depths_are_spread_over_what_a_screen_shows() -> None:
    depths = np.array([[1.0, 2.0], [3.0, np.inf]], np.float32)
    assert cvtColorForDisplay(depths, '32FC1', 'mono8', True).tolist() == [[0, 128], [255, 255]]
    bounded = cvtColorForDisplay(depths, '32FC1', 'bgr8', min_image_value=2.0, max_image_value=4.0)
    assert bounded[..., 0].tolist() == [[0, 0], [128, 255]]
    flat = cvtColorForDisplay(np.ones((2, 2), np.float32), '32FC1', 'mono8', True)
    assert flat.tolist() == [[127, 127], [127, 127]]


# -- names ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    'encoding', ['8U', '8UC1', '8UC3', '16SC2', '32FC4', '64FC1', 'bgr8', 'mono16', 'bayer_grbg16']
)
def test_types_are_those_of_the_opencv_that_is_there(encoding: str) -> None:
    cv2 = pytest.importorskip('cv2')
    generic = {'8U': '8UC1', 'bgr8': '8UC3', 'mono16': '16UC1', 'bayer_grbg16': '16UC1'}.get(
        encoding, encoding
    )
    number = getCvType(encoding)
    assert number == getattr(cv2, f'CV_{generic}')
    assert BRIDGE.cvtype_to_name[number] == generic
    dtype, channels = BRIDGE.cvtype2_to_dtype_with_channels(number)
    assert BRIDGE.dtype_with_channels_to_cvtype2(np.dtype(dtype), channels) == generic
    assert channels == cv_bridge_boost.CV_MAT_CNWrap(number)


def test_an_unknown_encoding_is_an_error_of_its_caller() -> None:
    with pytest.raises(RuntimeError, match='Unrecognized'):
        getCvType('rainbow')
    with pytest.raises(CvBridgeError, match='Unrecognized'):
        BRIDGE.encoding_to_cvtype2('rainbow')
    assert not set(cv_bridge.__all__) - set(dir(cv_bridge))
