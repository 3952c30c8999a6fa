"""cam2image and showimage: publish and show a moving test picture. Package `image_tools`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Image
from std_msgs.msg import Bool

from goalwire.apps.programs.running import UsageError, declare_number, declare_text, spin_with_words

BARS = (
    (255, 255, 255),
    (0, 255, 255),
    (255, 255, 0),
    (0, 255, 0),
    (255, 0, 255),
    (0, 0, 255),
    (255, 0, 0),
    (0, 0, 0),
)
"""Blue, green and red of the eight bars of a test picture."""
STEP = 4
"""The shift of the bars from one picture to the next, in pixels."""
LARGEST = 8192
"""The longest side of a picture, in pixels."""


class Cam2Image(Node):
    """Publishes bars that move on `image` (bgr8); `flip_image` (Bool) mirrors them.

    Parameters: `width` and `height` in pixels, `frequency` in Hz, `frame_id`, and the QoS: `reliability`
    ('reliable' or 'best_effort'), `history` ('keep_last' or 'keep_all'), `depth`. `burger_mode`,
    `show_camera` and `device_id` are accepted and change nothing: no camera is read.
    """

    def __init__(self) -> None:
        super().__init__('cam2image')
        qos = declare_qos(self)
        self._width = _declare_side(self, 'width', 320)
        self._height = _declare_side(self, 'height', 240)
        self._frame = declare_text(self, 'frame_id', 'camera_frame')
        for name, default in (('burger_mode', False), ('show_camera', False), ('device_id', 0)):
            self.declare_parameter(name, default)
        rate = declare_number(self, 'frequency', 30.0)
        if not 0.0 < rate < math.inf:
            raise UsageError(f'the parameter frequency is {rate}: it must be above 0')
        self._is_flipped = False
        self._count = 0
        self._publisher = self.create_publisher(Image, 'image', qos)
        self.create_subscription(Bool, 'flip_image', self._flip, 10)
        self.create_timer(1.0 / rate, self._publish)

    def _flip(self, message: Bool) -> None:
        self._is_flipped = message.data
        self.get_logger().info(f'Set flip mode to: {"on" if message.data else "off"}')

    def _publish(self) -> None:
        self._count += 1
        image = Image(height=self._height, width=self._width, encoding='bgr8', step=self._width * 3)
        image.header.stamp = self.get_clock().now().to_msg()
        image.header.frame_id = self._frame
        image.data = draw_bars(self._width, self._height, self._count * STEP, is_flipped=self._is_flipped)
        self.get_logger().info(f'Publishing image #{self._count}')
        self._publisher.publish(image)


class ShowImage(Node):
    """Receives pictures on `image` and logs each; names, once, the console page that shows them."""

    def __init__(self) -> None:
        super().__init__('showimage')
        qos = declare_qos(self)
        self.declare_parameter('show_image', value=True)
        declare_text(self, 'window_name', '')
        subscription = self.create_subscription(Image, 'image', self._take, qos)
        self.get_logger().info(
            f'The page of "goalwire console" shows the pictures: choose the topic {subscription.topic_name}'
        )

    def _take(self, image: Image) -> None:
        self.get_logger().info(f'Received image #{image.header.frame_id}')


def draw_bars(width: int, height: int, shift: int, *, is_flipped: bool = False) -> bytes:
    """Return a picture of eight vertical bars, moved `shift` pixels to the left; bgr8, without padding."""
    columns = [(column + shift) % width * len(BARS) // width for column in range(width)]
    if is_flipped:
        columns.reverse()
    return b''.join(bytes(BARS[bar]) for bar in columns) * height


def declare_qos(node: Node) -> QoSProfile:
    """Declare the parameters `reliability`, `history` and `depth`; return their QoS. Raises UsageError."""
    reliability = declare_text(node, 'reliability', 'reliable')
    history = declare_text(node, 'history', 'keep_last')
    depth = node.declare_parameter('depth', 10).get_parameter_value().integer_value
    if reliability not in {'reliable', 'best_effort'}:
        raise UsageError(f"the parameter reliability is '{reliability}': write reliable or best_effort")
    if history not in {'keep_last', 'keep_all'}:
        raise UsageError(f"the parameter history is '{history}': write keep_last or keep_all")
    if depth < 1:
        raise UsageError(f'the parameter depth is {depth}: it must be above 0')
    return QoSProfile(
        depth=depth,
        history=HistoryPolicy[history.upper()],
        reliability=ReliabilityPolicy[reliability.upper()],
    )


def _declare_side(node: Node, name: str, default: int) -> int:
    side = node.declare_parameter(name, default).get_parameter_value().integer_value
    if not 1 <= side <= LARGEST:
        raise UsageError(f'the parameter {name} is {side}: it must be from 1 to {LARGEST}')
    return side


def publish(argv: Sequence[str] | None = None) -> int:
    """Run cam2image."""
    return spin_with_words(
        'cam2image', '[--ros-args -p width:=640 -p height:=480 ...]', lambda _: Cam2Image(), argv
    )


def show(argv: Sequence[str] | None = None) -> int:
    """Run showimage."""
    return spin_with_words(
        'showimage', '[--ros-args -r image:=/camera/image ...]', lambda _: ShowImage(), argv
    )
