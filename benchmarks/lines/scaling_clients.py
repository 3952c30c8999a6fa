"""Many clients of one service, each with one call on its way: in one node, in a node or a process each."""

from __future__ import annotations

from contextlib import ExitStack
from time import perf_counter

from benchmarks import spinning, stage
from benchmarks.line import Figures
from benchmarks.lines.service_in_flight import Flight, measure
from benchmarks.lines.service_name import SERVICE

MODULE = 'benchmarks.lines.scaling_clients'
SERVER = 'benchmarks.lines.service_spin'
ONE_NODE, NODES, PROCESSES = 'one-node', 'nodes', 'processes'


def ask(count: int, clients: int, of: str = ONE_NODE) -> Figures:
    """Return the figures of `count` calls in all; `of` is what each client has of its own."""
    if of == PROCESSES:
        return _measure_processes(clients, count)
    return measure(clients, clients, count, has_nodes=of == NODES)


def _measure_processes(clients: int, count: int) -> Figures:
    with ExitStack() as stack:
        server = stack.enter_context(stage.Partner(SERVER))
        callers = [stack.enter_context(stage.Partner(MODULE, number)) for number in range(clients)]
        share = max(count // clients, 1)
        _call_all(callers, 10)
        before = server.do('cpu')
        begun = perf_counter()
        lost = _call_all(callers, share)
        took = perf_counter() - begun
        calls = share * clients
        return {
            'rate': (calls - lost) / took,
            'lost': lost,
            'cpu_there': (server.do('cpu') - before) / calls * 1e6,
        }


def _call_all(callers: list[stage.Partner], count: int) -> float:
    """Have all call at once, so many times each; return how many calls were not answered."""
    for caller in callers:
        caller.order('call', count)
    return sum(caller.result() for caller in callers)


def answer(number: int) -> None:
    """Be one of the calling processes."""
    import rclpy
    from std_srvs.srv import SetBool

    rclpy.init()
    node = rclpy.create_node(f'bench_client_{number}')
    client = node.create_client(SetBool, SERVICE)
    assert client.wait_for_service(spinning.PATIENCE_S)

    def call(count: int) -> int:
        flight = Flight([client], 1, count)
        flight.spin(node)
        return count - flight.answered

    stage.obey({'call': call})
    node.destroy_node()
    rclpy.shutdown()


if __name__ == '__main__':
    stage.run(ask, answer)
