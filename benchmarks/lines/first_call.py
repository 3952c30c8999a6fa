"""A client as small as clients get: import, node, discovery, one call. The lines startup and memory run it.

Its arguments are CLOCK, a reading of time.monotonic, and the service's name: it imports nothing of the suite.
Prints milliseconds from its first line and from CLOCK, milliseconds of CPU, and resident memory in MB.
"""

from time import monotonic, perf_counter

BEGUN = perf_counter()

import sys  # noqa: E402

import rclpy  # noqa: E402
from std_srvs.srv import SetBool  # noqa: E402


def main() -> None:
    rclpy.init()
    node = rclpy.create_node('bench_client')
    client = node.create_client(SetBool, sys.argv[2])
    client.wait_for_service(20.0)
    future = client.call_async(SetBool.Request(data=True))
    rclpy.spin_until_future_complete(node, future)
    answer = future.result()
    assert answer is not None
    assert answer.success
    inside, wall = perf_counter() - BEGUN, monotonic() - float(sys.argv[1])
    print(inside * 1e3, wall * 1e3, cpu() * 1e3, resident() / 1e6, flush=True)
    node.destroy_node()
    rclpy.shutdown()


def cpu() -> float:
    from time import process_time

    return process_time()


def resident() -> float:
    """Return the bytes of memory resident now, or where the system does not say, the most there were."""
    try:
        with open('/proc/self/statm') as file:  # noqa: PTH123 - pathlib would be in the figure
            import os

            return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')
    except OSError:
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


main()
