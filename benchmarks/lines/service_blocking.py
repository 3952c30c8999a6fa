"""A service called by the blocking `call`, while another thread spins the node."""

from __future__ import annotations

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of
from benchmarks.lines.service_name import SERVICE
from benchmarks.lines.service_spin import answer
from benchmarks.spinning import BackgroundSpin

LINE = Line(
    'service call, blocking `call` with a spinning thread',
    __name__,
    2000,
    ('p50', 'p99', 'cpu'),
    (Goal('p50', Of.REFERENCE, 0.4, 0.4),),
    {'p50': 394},
    floor='service',
)


def ask(count: int) -> Figures:
    import rclpy
    from std_srvs.srv import SetBool

    with stage.Partner('benchmarks.lines.service_spin') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_client')
        client = node.create_client(SetBool, SERVICE)
        with BackgroundSpin(node):
            assert client.wait_for_service(spinning.PATIENCE_S)
            request = SetBool.Request(data=True)
            figures = stage.round_trips(lambda: client.call(request), count, partner)
        node.destroy_node()
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
