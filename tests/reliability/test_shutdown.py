"""Item 16: the end of a context wakes whoever waits within a second, although no answer can come any more."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress

from helpers.collector import Collector
from helpers.outcomes import Outcomes
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

from goalwire.errors import GoalwireError
from goalwire.transport.faults import Faults, Loss

from .conftest import Evidence


def test_everybody_who_waits_is_woken_within_a_second_by_the_end_of_the_context(
    isolated: dict[str, str], evidence: Evidence
) -> None:
    outcomes = Outcomes()
    with Faults(Loss()):
        ours, theirs = Context(), Context()
        for context in (ours, theirs):
            context.init(args=[])
        node, server = Node('node', context=ours), Node('server', context=theirs)
        server.create_service(Trigger, 'ask', lambda _, response: response)
        client = node.create_client(Trigger, 'ask')
        assert client.wait_for_service(10.0)
        nobody = node.create_client(Trigger, 'nobody')
        executor = SingleThreadedExecutor(context=ours)
        executor.add_node(node)
        begun, ended = Collector[None](), Collector[float]()

        def waiting(wait: Callable[[], object]) -> threading.Thread:
            def run() -> None:
                begun(None)
                with suppress(GoalwireError):
                    wait()
                ended(time.monotonic())

            thread = threading.Thread(target=run)
            thread.start()
            return thread

        threads = [
            waiting(wait)
            for wait in (
                lambda: client.call(Trigger.Request()),
                nobody.wait_for_service,
                executor.spin,
                lambda: node.get_clock().sleep_for(Duration(seconds=60), ours),
            )
        ]
        begun.expect(len(threads))
        asked = time.monotonic()
        ours.shutdown()
        for at in ended.expect(len(threads)):
            outcomes.note('woken', at - asked)
        for thread in threads:
            thread.join()
        theirs.shutdown()
    outcomes.expect_within(1.0)
    evidence(16, 'shutdown under four that wait, on a wire that loses everything', outcomes)
