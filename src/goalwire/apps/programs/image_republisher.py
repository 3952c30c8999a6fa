"""republish: converts a topic of pictures between raw and compressed. Package `image_transport`.

The topics are `in` and `out` for raw pictures, `in/compressed` and `out/compressed` for compressed ones.
"""

from __future__ import annotations

from collections.abc import Sequence

from cv_bridge import CvBridge, CvBridgeError
from cv_bridge.conversion import require_opencv
from cv_bridge.encodings import ConversionError, encoding_of
from rclpy.node import Node
from sensor_msgs.msg import CompressedImage, Image

from goalwire.apps.programs.running import UsageError, declare_text, spin_with_words

USAGE = 'raw|compressed [raw|compressed] --ros-args -r in:=/camera -r out/compressed:=/camera/compressed'
TRANSPORTS = ('raw', 'compressed')
FORMATS = {'jpeg': 'jpg', 'png': 'png'}
DEPTH = 10


class Republisher(Node):
    """Republishes pictures of one transport on another; without an `out_transport`, as raw and compressed.

    Parameters: `in_transport` and `out_transport` instead of the arguments, and `out.compressed.format`,
    'jpeg' or 'png'. Pictures with 16 bits or an alpha channel need PNG.
    """

    def __init__(self, words: list[str]) -> None:
        """`words` are the names of transports. Raises UsageError for unknown names, and without OpenCV."""
        super().__init__('image_republisher')
        source, target = [*words, '', ''][:2]
        source = declare_text(self, 'in_transport', source or 'raw')
        target = declare_text(self, 'out_transport', target)
        self._format = declare_text(self, 'out.compressed.format', 'jpeg')
        _check(words, source, target, self._format)
        self._bridge = CvBridge()
        self._raw = None if target == 'compressed' else self.create_publisher(Image, 'out', DEPTH)
        self._compressed = (
            None if target == 'raw' else self.create_publisher(CompressedImage, 'out/compressed', DEPTH)
        )
        if source == 'raw':
            self.create_subscription(Image, 'in', self._take_raw, DEPTH)
        else:
            self.create_subscription(CompressedImage, 'in/compressed', self._take_compressed, DEPTH)

    def _take_raw(self, image: Image) -> None:
        if self._raw is not None:
            self._raw.publish(image)
        if self._compressed is None:
            return
        try:
            self._compressed.publish(self._compress(image))
        except CvBridgeError as error:
            self._tell(error)

    def _take_compressed(self, image: CompressedImage) -> None:
        if self._compressed is not None:
            self._compressed.publish(image)
        if self._raw is None:
            return
        try:
            self._raw.publish(self._unpack(image))
        except CvBridgeError as error:
            self._tell(error)

    def _compress(self, image: Image) -> CompressedImage:
        """Return a compressed picture whose format names the encoding, as in compressed_image_transport."""
        encoding = encoding_of(image.encoding)
        target = image.encoding
        if encoding.kind and encoding.kind != 'gray':
            target = f'{"bgra" if "a" in encoding.kind else "bgr"}{encoding.bits}'
        if self._format == 'jpeg' and (encoding.bits != 8 or target.startswith('bgra')):
            raise CvBridgeError(
                f'JPEG cannot hold pictures in {image.encoding}: choose -p out.compressed.format:=png'
            )
        picture = self._bridge.imgmsg_to_cv2(image, target)
        message = self._bridge.cv2_to_compressed_imgmsg(picture, FORMATS[self._format])
        message.header = image.header
        message.format = f'{image.encoding}; {self._format} compressed {target}'
        return message

    def _unpack(self, image: CompressedImage) -> Image:
        """Return a raw picture in the encoding that its format names, or else in its file's own encoding."""
        picture = self._bridge.compressed_imgmsg_to_cv2(image)
        channels = 1 if picture.ndim == 2 else picture.shape[2]
        own = f'{ {1: "mono", 3: "bgr", 4: "bgra"}.get(channels, "") }{picture.dtype.itemsize * 8}'
        named, has_name, _ = image.format.partition(';')
        encoding = named.strip() if has_name else own
        if encoding != own:
            picture = self._bridge.compressed_imgmsg_to_cv2(image, encoding)
        return self._bridge.cv2_to_imgmsg(picture, encoding, image.header)

    def _tell(self, error: CvBridgeError) -> None:
        self.get_logger().error(f'a picture was left out: {error}', throttle_duration_sec=5.0)


def _check(words: list[str], source: str, target: str, picture_format: str) -> None:
    """Raise UsageError for unknown transports or formats, and for too many arguments."""
    if len(words) > 2:
        raise UsageError(f'there are {len(words)} arguments; give two transports at most')
    for transport in (source, target):
        if transport and transport not in TRANSPORTS:
            raise UsageError(f"there is no transport '{transport}': choose {' or '.join(TRANSPORTS)}")
    if picture_format not in FORMATS:
        raise UsageError(f"there is no format '{picture_format}': choose {' or '.join(FORMATS)}")
    if (source, target) != ('raw', 'raw'):
        try:
            require_opencv('compressed pictures')
        except ConversionError as error:
            raise UsageError(str(error)) from None


def main(argv: Sequence[str] | None = None) -> int:
    """Run republish."""
    return spin_with_words('republish', USAGE, Republisher, argv)
