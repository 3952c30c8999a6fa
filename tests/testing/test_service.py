"""Scripted services, seen by their clients."""

from __future__ import annotations

import asyncio
import threading
import time

import pytest
import rclpy
from std_srvs.srv import SetBool

from goalwire import DeadlineError, ServerFailedError, ServerLostError
from goalwire.testing import NEVER, Graph, VirtualClock, after

YES = SetBool.Response(success=True, message='yes')
NO = SetBool.Response(success=False, message='no')


def test_without_a_script_every_request_gets_the_default_response(graph: Graph) -> None:
    graph.service(SetBool, 'set')
    assert graph.call(SetBool, 'set', data=True) == SetBool.Response()


def test_one_answer_is_given_to_every_request_and_all_requests_are_noted(graph: Graph) -> None:
    service = graph.service(SetBool, 'set', YES)
    assert [graph.call(SetBool, 'set', data=data) for data in (True, False)] == [YES, YES]
    assert service.requests == [SetBool.Request(data=True), SetBool.Request(data=False)]


def test_a_list_answers_each_request_in_turn(graph: Graph) -> None:
    graph.service(SetBool, 'set', [YES, NO])
    assert [graph.call(SetBool, 'set') for _ in range(2)] == [YES, NO]


def test_a_request_beyond_the_list_fails_and_so_does_the_test(clock: VirtualClock) -> None:
    def play() -> None:
        with Graph() as graph:
            graph.service(SetBool, 'set', [YES])
            graph.call(SetBool, 'set')
            with pytest.raises(ServerFailedError):
                graph.call(SetBool, 'set')

    with pytest.raises(AssertionError, match="service '/set': call 2 came, and there are 1 answers"):
        play()


def test_a_function_makes_the_answer_of_the_request(graph: Graph) -> None:
    graph.service(SetBool, 'set', lambda request: SetBool.Response(success=request.data))
    assert [graph.call(SetBool, 'set', data=data).success for data in (True, False)] == [True, False]


def test_a_coroutine_function_may_take_its_time(graph: Graph, clock: VirtualClock) -> None:
    async def answer(request: SetBool.Request) -> SetBool.Response:
        await asyncio.sleep(3.0)
        return YES

    graph.service(SetBool, 'set', answer)
    assert graph.call(SetBool, 'set') == YES
    assert clock.elapsed == 3.0


@pytest.mark.parametrize('error', [ValueError('out of order'), ValueError])
def test_a_handler_that_raises_fails_the_call_alone(
    graph: Graph, error: ValueError | type[ValueError]
) -> None:
    graph.service(SetBool, 'set', [error, YES])
    with pytest.raises(ServerFailedError, match='ValueError'):
        graph.call(SetBool, 'set')
    assert graph.call(SetBool, 'set') == YES


def test_an_answer_may_come_late_and_others_meanwhile(graph: Graph, clock: VirtualClock) -> None:
    graph.service(SetBool, 'set', [after(2.0, YES), NO])
    answers: list[tuple[float, SetBool.Response]] = []

    def call() -> None:
        response = graph.call(SetBool, 'set')
        answers.append((clock.elapsed, response))

    threads = [threading.Thread(target=call) for _ in range(2)]
    for thread in threads:
        thread.start()
        time.sleep(0.5)
    for thread in threads:
        thread.join()
    assert answers == [(0.5, NO), (2.0, YES)]


def test_what_never_answers_keeps_its_client_waiting_until_its_deadline(
    graph: Graph, clock: VirtualClock
) -> None:
    graph.service(SetBool, 'set', NEVER)
    with pytest.raises(DeadlineError, match=r"service '/set' of node '/fake_set': .* waited 7\.000 s"):
        graph.call(SetBool, 'set', timeout=7.0)
    assert clock.elapsed == 7.0


def test_a_service_that_closes_is_a_server_that_dies(graph: Graph, clock: VirtualClock) -> None:
    service = graph.service(SetBool, 'set', NEVER)
    threading.Timer(1.0, service.close).start()
    with pytest.raises(ServerLostError):
        graph.call(SetBool, 'set', timeout=60.0)
    assert clock.elapsed == 1.0


def test_the_script_may_be_changed_on_the_way(graph: Graph) -> None:
    service = graph.service(SetBool, 'set', NO)
    assert graph.call(SetBool, 'set') == NO
    service.answer_with(YES)
    assert graph.call(SetBool, 'set') == YES


def test_a_client_of_rclpy_is_answered_too(graph: Graph) -> None:
    service = graph.service(SetBool, 'set', YES, node='lamp')
    rclpy.init(args=[])
    with rclpy.create_node('finger') as node:
        client = node.create_client(SetBool, 'set')
        assert client.wait_for_service(timeout_sec=1.0)
        assert client.call(SetBool.Request(data=True), timeout_sec=1.0) == YES
        assert '/lamp' in graph.nodes()
    rclpy.shutdown()
    service.assert_called_with(data=True)


def test_what_was_called_and_how_can_be_asserted(graph: Graph) -> None:
    service = graph.service(SetBool, 'set', YES)
    service.assert_not_called()
    with pytest.raises(AssertionError, match="service '/set' was not called"):
        service.assert_called()
    graph.call(SetBool, 'set', data=True)
    service.assert_called()
    service.assert_called(1)
    service.assert_called_with(data=True)
    with pytest.raises(AssertionError, match="service '/set', last call: data is True, not False"):
        service.assert_called_with(data=False)
    with pytest.raises(
        AssertionError, match=r"'/set': wanted 2 calls, got 1:\n  .*SetBool_Request\(data=True\)"
    ):
        service.assert_called(2)
    with pytest.raises(AssertionError, match='wanted 0 calls, got 1'):
        service.assert_not_called()


def test_a_call_that_will_come_is_waited_for(graph: Graph, clock: VirtualClock) -> None:
    service = graph.service(SetBool, 'set', YES)
    caller = threading.Timer(2.0, graph.call, [SetBool, 'set', SetBool.Request(data=True)])
    caller.start()
    assert service.wait_for(timeout=3.0) == [SetBool.Request(data=True)]
    caller.join()
    with pytest.raises(AssertionError, match=r"wanted 2 requests to '/set' within 3 s, got 1:"):
        service.wait_for(2, timeout=3.0)
    assert clock.elapsed == 5.0
