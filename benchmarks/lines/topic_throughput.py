"""PoseStamped published as fast as one thread can, taken by a callback in another process."""

from __future__ import annotations

from time import perf_counter

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of

LINE = Line(
    'topic throughput, PoseStamped to a callback',
    __name__,
    40_000,
    ('rate', 'arrived', 'cpu_here'),
    (
        Goal('rate', Of.REFERENCE, 15, 6, at_least=True),
        Goal('cpu_here', Of.REFERENCE, 0.08, 0.15),
    ),
    {'rate': 8400, 'cpu_here': 123},
    floor='throughput',
)
TOPIC = 'bench_stream'
LAST = 'last'
DEPTH = 1000


def answer() -> None:
    import rclpy
    from geometry_msgs.msg import PoseStamped

    rclpy.init()
    node = rclpy.create_node('bench_source')
    publisher = node.create_publisher(PoseStamped, TOPIC, DEPTH)

    def send(count: int) -> None:
        pose = PoseStamped()
        pose.header.frame_id = 'map'
        for _ in range(count - 1):
            publisher.publish(pose)
        pose.header.frame_id = LAST
        publisher.publish(pose)

    stage.obey({'send': send})
    node.destroy_node()
    rclpy.shutdown()


def ask(count: int) -> Figures:
    import rclpy
    from geometry_msgs.msg import PoseStamped
    from rclpy.task import Future

    with stage.Partner('benchmarks.lines.topic_throughput') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_sink')
        arrivals: list[float] = []
        ended: Future[None] = Future()

        def take(pose: PoseStamped) -> None:
            arrivals.append(perf_counter())
            if pose.header.frame_id == LAST:
                ended.set_result(None)

        subscription = node.create_subscription(PoseStamped, TOPIC, take, DEPTH)
        while not node.count_publishers(TOPIC):
            spinning.spin_once(node, timeout_sec=0.01)
        while not ended.done():  # what is sent before both have met is lost
            partner.do('send', 100)
            spinning.spin_until_done(node, ended, 0.1)
        arrivals.clear()
        ended = Future()
        meter = stage.Meter(partner)
        partner.order('send', count)
        spinning.spin_until_done(node, ended, 2 * spinning.PATIENCE_S)
        partner.result()
        figures = meter.read(len(arrivals))
        node.destroy_subscription(subscription)
        node.destroy_node()
        rclpy.shutdown()
        return figures | {
            'rate': (len(arrivals) - 1) / (arrivals[-1] - arrivals[0]),
            'arrived': len(arrivals) / count,
        }


if __name__ == '__main__':
    stage.run(ask, answer)
