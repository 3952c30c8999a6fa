"""A service called by call_async, then spin_until_future_complete."""

from __future__ import annotations

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of
from benchmarks.lines.service_name import SERVICE

LINE = Line(
    'service call, `call_async` + `spin_until_future_complete`',
    __name__,
    2000,
    ('p50', 'p99', 'cpu'),
    (
        Goal('p50', Of.REFERENCE, 0.3, 0.55, no_look=0.55),
        Goal('p50', Of.RAW, None, 1.15),
        Goal('cpu', Of.REFERENCE, 0.3, 0.3, no_look=0.3),
    ),
    {'p50': 216, 'cpu': 430},
    floor='service',
)
PINNED = LINE._replace(
    name='the same call, processes pinned apart',
    goals=(Goal('p50', Of.REFERENCE, 0.3, None, no_look=0.55),),
    pinned=True,
)


def answer() -> None:
    import rclpy
    from std_srvs.srv import SetBool

    def switch(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = request.data
        response.message = 'switched'
        return response

    rclpy.init()
    node = rclpy.create_node('bench_server')
    node.create_service(SetBool, SERVICE, switch)
    stage.serve(node)


def ask(count: int) -> Figures:
    import rclpy
    from std_srvs.srv import SetBool

    with stage.Partner('benchmarks.lines.service_spin') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_client')
        client = node.create_client(SetBool, SERVICE)
        assert client.wait_for_service(spinning.PATIENCE_S)
        request = SetBool.Request(data=True)

        def call() -> None:
            future = client.call_async(request)
            spinning.spin_until_done(node, future)
            answer = future.result()
            assert answer is not None
            assert answer.success

        figures = stage.round_trips(call, count, partner)
        node.destroy_node()
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
