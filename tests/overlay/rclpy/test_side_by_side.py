"""Many threads use contexts, nodes, entities, tasks and futures at the same time, and nothing is lost.

On a free-threaded Python the threads run side by side. There `pytest --parallel-threads 4` of
pytest-run-parallel 0.3.1 runs each of these tests on four threads at once, in one context. (Later versions
run tests that use `monkeypatch` on one thread.)
"""

from __future__ import annotations

from collections import Counter
from functools import partial
from itertools import count
from threading import Event

from example_interfaces.srv import AddTwoInts
from helpers.at_once import do_at_once
from helpers.collector import Collector
from helpers.patience import PATIENCE, soon
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import String

THREADS = 8
_NUMBERS = count()
"""Numbers for names: each topic and each service of these tests has a name of its own."""


def _add(request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
    response.sum = request.a + request.b
    return response


def test_contexts_open_serve_and_end_beside_each_other(isolated: dict[str, str]) -> None:
    def live(number: int) -> None:
        context, name = Context(), f'add_{next(_NUMBERS)}'
        context.init(args=[])
        try:
            node = Node('adder', context=context)
            node.create_service(AddTwoInts, name, _add)
            client = node.create_client(AddTwoInts, name)
            assert client.wait_for_service(PATIENCE)
            with SingleThreadedExecutor(context=context) as executor:
                executor.add_node(node)
                answer = client.call_async(AddTwoInts.Request(a=number, b=1))
                executor.spin_until_future_complete(answer, PATIENCE)
                assert result_of(answer).sum == number + 1
            node.destroy_node()
        finally:
            context.try_shutdown()

    do_at_once(THREADS, live)


def test_entities_of_a_node_that_spins_come_and_go_on_many_threads(make_node: MakeNode, spin: Spin) -> None:
    node = make_node(f'node_{next(_NUMBERS)}')
    spin(node, threads=4)
    before = len(list(node.publishers)), len(list(node.subscriptions))

    def come_and_go(_number: int) -> None:
        for _ in range(10):
            topic, heard = f'topic_{next(_NUMBERS)}', Collector[String]()
            subscription = node.create_subscription(String, topic, heard, 10)
            publisher = node.create_publisher(String, topic, 10)
            publisher.publish(String(data=topic))
            assert [message.data for message in heard.expect()] == [topic]
            assert node.destroy_subscription(subscription)
            assert node.destroy_publisher(publisher)

    do_at_once(THREADS, come_and_go)
    assert (len(list(node.publishers)), len(list(node.subscriptions))) == before


def test_each_of_many_threads_gets_its_own_answers_from_one_client(make_node: MakeNode, spin: Spin) -> None:
    server, node, name = make_node('server'), make_node(), f'add_{next(_NUMBERS)}'
    server.create_service(AddTwoInts, name, _add)
    client = node.create_client(AddTwoInts, name)
    spin(server, node, threads=4)
    assert client.wait_for_service(PATIENCE)

    def ask(number: int) -> None:
        for question in range(25):
            answer = client.call(AddTwoInts.Request(a=1000 * number, b=question), timeout_sec=PATIENCE)
            assert answer is not None
            assert answer.sum == 1000 * number + question

    do_at_once(THREADS, ask)


def test_a_task_from_any_thread_runs_once(make_node: MakeNode, spin: Spin) -> None:
    executor = spin(make_node(), threads=4).executor
    runs: Collector[int] = Collector()

    def run(task: int) -> str:
        runs(task)
        return str(task)

    def give_tasks(number: int) -> None:
        mine = range(100 * number, 100 * number + 50)
        futures = [executor.create_task(run, task) for task in mine]
        assert [result_of(future) for future in futures] == [str(task) for task in mine]

    do_at_once(THREADS, give_tasks)
    assert Counter(runs.items) == Counter(100 * n + step for n in range(THREADS) for step in range(50))


def test_each_callback_of_a_future_is_called_once_whoever_settles_it() -> None:
    for _ in range(20):
        _settle_while_callbacks_are_added(Future[str]())


def _settle_while_callbacks_are_added(future: Future[str]) -> None:
    called: Collector[int] = Collector()

    def note(callback: int, _future: Future[str]) -> None:
        called(callback)

    def add_callbacks(number: int) -> None:
        for step in range(20):
            if (number, step) == (0, 10):
                future.set_result('done')
            future.add_done_callback(partial(note, 20 * number + step))

    do_at_once(4, add_callbacks)
    assert sorted(called.expect(80)) == list(range(80))


def test_timers_of_a_node_that_spins_are_made_and_destroyed_on_many_threads(
    make_node: MakeNode, spin: Spin
) -> None:
    node = make_node(f'node_{next(_NUMBERS)}')
    spin(node, threads=4)

    def tick(_number: int) -> None:
        for _ in range(5):
            ticked = Event()
            timer = node.create_timer(0.001, ticked.set)
            assert soon(ticked)
            assert node.destroy_timer(timer)

    do_at_once(THREADS, tick)
    assert list(node.timers) == []
