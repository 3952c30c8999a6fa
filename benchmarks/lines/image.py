"""A large message from `publish` to the callback in another process, one at a time."""

from __future__ import annotations

from array import array
from time import perf_counter

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of

LINE = Line(
    '1 MB image to a callback',
    __name__,
    300,
    ('p50', 'p99', 'cpu'),
    (
        Goal('p50', Of.ECLIPSE, 1.0, None),
        Goal('p50', Of.TCP, 1.3, None),
        Goal('p50', Of.RAW, None, 1.3),
    ),
    floor='image',
)
IMAGE, SEEN = 'bench_image', 'bench_seen'
SIZE = 1_000_000


def answer() -> None:
    import rclpy
    from sensor_msgs.msg import Image
    from std_msgs.msg import Float64

    rclpy.init()
    node = rclpy.create_node('bench_viewer')
    seen = node.create_publisher(Float64, SEEN, 10)

    def view(_image: Image) -> None:
        seen.publish(Float64(data=perf_counter()))  # one clock for all processes of a machine

    node.create_subscription(Image, IMAGE, view, 10)
    stage.serve(node)


def measure(count: int, size: int) -> Figures:
    import rclpy
    from rclpy.node import Node
    from sensor_msgs.msg import Image
    from std_msgs.msg import Float64

    with stage.Partner('benchmarks.lines.image') as partner:
        rclpy.init()
        node: Node = rclpy.create_node('bench_camera')
        seen: list[Float64] = spinning.arrivals()
        node.create_subscription(Float64, SEEN, seen.append, 10)
        publisher = node.create_publisher(Image, IMAGE, 10)
        image = Image(height=1, width=size, step=size, encoding='mono8', data=array('B', bytes(size)))
        while not seen:
            publisher.publish(image)
            spinning.spin_once(node, timeout_sec=0.5)

        def send() -> float:
            seen.clear()
            begun = perf_counter()
            publisher.publish(image)
            spinning.spin_until_any(node, seen)
            return seen[0].data - begun

        figures = stage.reported(send, count, partner)
        node.destroy_node()
        rclpy.shutdown()
        return figures


def ask(count: int) -> Figures:
    return measure(count, SIZE)


if __name__ == '__main__':
    stage.run(ask, answer)
