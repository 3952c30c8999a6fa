"""A timer of 1 kHz in a node that does nothing else: CPU of one tick."""

from __future__ import annotations

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of

LINE = Line(
    '1 kHz timer',
    __name__,
    1500,
    ('cpu', 'rate'),
    (Goal('cpu', Of.REFERENCE, 0.12, 0.15),),
    {'cpu': 179},
    looks=False,
)


def ask(count: int) -> Figures:
    import rclpy
    from rclpy.task import Future

    rclpy.init()
    node = rclpy.create_node('bench_timer')
    ticks = 0
    done: Future[None] = Future()

    def tick() -> None:
        nonlocal ticks
        ticks += 1
        if ticks == stage.WARM_UP + count:
            done.set_result(None)

    timer = node.create_timer(0.001, tick)
    while ticks < stage.WARM_UP:
        spinning.spin_once(node)
    before = ticks
    meter, watch = stage.Meter(), stage.Stopwatch()
    spinning.spin_until_done(node, done)
    figures = meter.read(ticks - before) | {'rate': (ticks - before) / watch.read()}
    node.destroy_timer(timer)
    node.destroy_node()
    rclpy.shutdown()
    return figures


if __name__ == '__main__':
    stage.run(ask, lambda: None)
