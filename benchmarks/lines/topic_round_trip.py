"""A PoseStamped sent to another process and back, callbacks on both sides."""

from __future__ import annotations

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of

LINE = Line(
    'topic round trip, PoseStamped, callbacks both sides',
    __name__,
    2000,
    ('p50', 'p99', 'cpu'),
    (Goal('p50', Of.REFERENCE, 0.3, 0.33, no_look=0.3),),
    {'p50': 448},
    floor='topic',
)
PINNED = LINE._replace(
    name='the same round trip, processes pinned apart',
    goals=(Goal('p50', Of.REFERENCE, 0.3, None, no_look=0.3),),
    pinned=True,
)
PING, PONG = 'bench_ping', 'bench_pong'


def answer() -> None:
    import rclpy
    from geometry_msgs.msg import PoseStamped

    rclpy.init()
    node = rclpy.create_node('bench_server')
    pong = node.create_publisher(PoseStamped, PONG, 10)
    node.create_subscription(PoseStamped, PING, pong.publish, 10)
    stage.serve(node)


def ask(count: int) -> Figures:
    import rclpy
    from geometry_msgs.msg import PoseStamped

    with stage.Partner('benchmarks.lines.topic_round_trip') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_client')
        received: list[PoseStamped] = spinning.arrivals()
        node.create_subscription(PoseStamped, PONG, received.append, 10)
        ping = node.create_publisher(PoseStamped, PING, 10)
        pose = PoseStamped()
        pose.header.frame_id = 'map'

        def exchange() -> None:
            received.clear()
            ping.publish(pose)
            spinning.spin_until_any(node, received)

        while not received:  # until both ends have found each other
            ping.publish(pose)
            spinning.spin_once(node, timeout_sec=0.1)
        figures = stage.round_trips(exchange, count, partner)
        node.destroy_node()
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
