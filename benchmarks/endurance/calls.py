"""Service calls, one after the other: what client and server hold after a tenth of them, and at the end."""

from __future__ import annotations

import os
from time import process_time

from benchmarks import spinning, stage
from benchmarks.endurance.held import Held
from benchmarks.line import Figures
from benchmarks.lines.service_name import SERVICE


def ask(count: int) -> Figures:
    import rclpy
    from std_srvs.srv import SetBool

    with stage.Partner('benchmarks.lines.service_spin') as partner:
        rclpy.init()
        node = rclpy.create_node('endurance_client')
        client = node.create_client(SetBool, SERVICE)
        assert client.wait_for_service(spinning.PATIENCE_S)

        def call(number: int) -> float:
            """Call one after the other; return how much processor time that took here."""
            before = process_time()
            for at in range(number):
                future = client.call_async(SetBool.Request(data=bool(at % 2)))
                spinning.spin_until_done(node, future)
                answer = future.result()
                assert answer is not None
                assert answer.success == bool(at % 2)
            return process_time() - before

        call(count // 10)
        held = Held(client=os.getpid(), server=partner.pid)
        first, second = call(count * 45 // 100), call(count * 45 // 100)
        figures = held.since() | {'first half CPU s': first, 'second half CPU s': second}
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, lambda: None)
