"""Starts children in every way, at every time, which end in every way; looks at both sides each time.

matrix.py all: every case. matrix.py some NUMBER: those of them that a diagonal meets, another one for each
number. It makes its pipes in the working folder. A program counts_calls.py must run beside it. Its answers
say whether this process's data is right.
"""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from functools import partial
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import child
from child import ENDS

WAYS = ('fork', 'double fork', 'exec', 'subprocess', 'preexec_fn', 'spawn', 'forkserver', 'pool', 'futures')
TIMES = ('before init', 'open', 'in a callback', 'in a coroutine', 'after shutdown')
KEPT_SOCKETS = os.environ.get('KEPT_SOCKETS') == '1'
"""Whether children of a fork keep copies of the parent's sockets, which a library of another project has."""
LIMIT_S, CASE_S = 20.0, 60

ended_in_child: list[str] = []
"""Not empty in a forked child that ends by returning: then everything returns."""
failures: list[str] = []
files: dict[int, bytes] = {}
"""The contents of the files that the children of a fork inherit, by descriptor."""


def wait_readable(descriptor: int) -> bool:
    """Whether a descriptor becomes readable in time."""
    return bool(select.select([descriptor], [], [], LIMIT_S)[0])


class Case:
    """One child: how and when it is started, and how it ends."""

    def __init__(self, way: str, time: str, end: str) -> None:
        self.title = f'{way}, {time}, {end}'
        self.way, self.end = way, end
        self.pipe = os.path.abspath('pipe')  # noqa: PTH100
        os.mkfifo(self.pipe)
        self._reader = os.open(self.pipe, os.O_RDONLY | os.O_NONBLOCK)

    def complain(self, text: str) -> None:
        """Note a failure."""
        failures.append(f'{self.title}: {text}')

    def run(self) -> None:
        """Start the child, and see it end. In a forked child this returns, too, if that is its way to end."""
        print(self.title, flush=True)
        signal.alarm(CASE_S)  # children do not inherit it
        getattr(self, '_' + self.way.replace(' ', '_'))()
        if ended_in_child:
            return
        signal.alarm(0)
        for each in child.complaints(files):
            self.complain(f'in the parent {each}')
        os.close(self._reader)
        os.unlink(self.pipe)  # noqa: PTH108

    def _look(self) -> list[str]:
        """In a forked child: look at the parent's files and sockets."""
        found = child.complaints(files)
        if not KEPT_SOCKETS and (sockets := child.network_sockets()):
            found.append(f'has sockets of the parent: {sockets}')
        return found

    def _live(self, own: Mapping[int, bytes] = MappingProxyType({})) -> None:
        """Be the forked child, which has files of its own, too."""
        child.live(self.pipe, self.end, lambda: [*self._look(), *child.complaints(own)])
        ended_in_child.append(self.title)

    # -- what the parent does

    def _hear(self) -> int | None:
        """Read the report; return the child's process id."""
        text = b''
        while not text.endswith(b'end'):
            if not wait_readable(self._reader):
                self.complain('no report')
                return None
            read = os.read(self._reader, 4096)
            text += read
            if not read:
                self.complain(f'a report in part: {text!r}')
                return None
        pid, *found, _ = text.decode().splitlines()
        for each in found:
            self.complain(each)
        return int(pid)

    def _kill(self) -> int | None:
        """Hear of the child, end it if that is its way; return its process id."""
        pid = self._hear()
        if pid is not None and self.end.startswith('SIG'):
            os.kill(pid, signal.Signals[self.end])
        return pid

    def _expect(self, code: int | None) -> None:
        if code != ENDS[self.end]:
            self.complain(f'ended with {code} and not {ENDS[self.end]}')

    def _wait(self, pid: int) -> None:
        """Wait for a child of this process."""
        self._kill()
        descriptor = os.pidfd_open(pid)
        if not wait_readable(descriptor):
            self.complain('the child still runs')
            os.kill(pid, signal.SIGKILL)
        os.close(descriptor)
        self._expect(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))

    # -- the ways

    def _fork(self) -> None:
        pid = os.fork()
        if pid == 0:
            self._live()
        else:
            self._wait(pid)

    def _double_fork(self) -> None:
        gone_reader, gone = os.pipe()  # it ends with the last process that has it
        pid = os.fork()
        if pid:
            os.close(gone)
            os.waitpid(pid, 0)
            self._kill()
            if not wait_readable(gone_reader):
                self.complain('the grandchild still runs')
            os.close(gone_reader)
            return
        os.setsid()
        own = child.open_files(8)
        if os.fork():
            os._exit(0)
        self._live(own)

    def _command(self) -> list[str]:
        return [sys.executable, '-S', '-E', child.__file__, self.pipe, self.end]

    def _exec(self) -> None:
        pid = os.fork()
        if pid == 0:
            os.execv(sys.executable, self._command())
        self._wait(pid)

    def _subprocess(self, preexec_fn: Callable[[], object] | None = None) -> None:
        with subprocess.Popen(
            self._command(),
            preexec_fn=preexec_fn,  # noqa: PLW1509 - what is tested
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
        ) as process:
            self._kill()
            with suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=LIMIT_S)
            self._expect(process.poll())
            process.kill()

    def _preexec_fn(self) -> None:
        self._subprocess(os.getpid)

    def _multiprocess(self) -> None:
        method = multiprocessing.get_context(self.way)
        process: Any = method.Process(target=child.live, args=(self.pipe, self.end))  # type: ignore[attr-defined]
        process.start()
        self._kill()
        process.join(LIMIT_S)
        self._expect(process.exitcode)
        process.kill()

    _spawn = _forkserver = _multiprocess

    def _pool(self) -> None:
        with multiprocessing.get_context('fork').Pool(2) as pool:
            if pool.map(abs, [-1, 2]) != [1, 2]:
                self.complain('the pool counts wrong')
            pool.apply_async(child.live, (self.pipe, self.end, self._look_in_pool))
            self._kill()

    def _futures(self) -> None:
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context('fork')) as pool:
            if list(pool.map(abs, [-1, 2])) != [1, 2]:
                self.complain('the pool counts wrong')
            future = pool.submit(child.live, self.pipe, self.end, self._look_in_pool)
            self._kill()
            with suppress(BaseException):  # as its end asks for
                future.result(LIMIT_S)

    @property
    def _look_in_pool(self) -> Callable[[], list[str]]:
        return partial(child.complaints, dict(files))


class Parent:
    """The program with the context, which starts the children."""

    def __init__(self, cases: list[tuple[str, str, str]]) -> None:
        self.cases = cases
        self.threads = set(threading.enumerate())
        self.sockets = child.network_sockets()
        self.calls = 0

    def of(self, time: str) -> Iterator[Case]:
        """Make the cases of a time, one after the other."""
        for way, when, end in self.cases:
            if when == time and not ended_in_child:
                yield Case(way, when, end)

    def run(self) -> None:
        """Run all cases; returns early in a forked child."""
        self.run_plain('before init')
        if not ended_in_child:
            self.run_open()
        if ended_in_child:
            return
        self.check_left()
        files.update(child.open_files(16))  # they get the numbers that have become free
        self.run_plain('after shutdown')

    def run_plain(self, time: str) -> None:
        """Run the cases of a time at which there is no context."""
        for case in self.of(time):
            case.run()

    def run_open(self) -> None:
        """Run the cases with a context."""
        import rclpy
        from std_srvs.srv import SetBool

        rclpy.init()
        node = rclpy.create_node('parent')
        client = node.create_client(SetBool, 'count')
        try:
            if not client.wait_for_service(timeout_sec=LIMIT_S):
                failures.append('counts_calls is not there')
                return
            executor = rclpy.get_global_executor()
            executor.add_node(node)
            self.node, self.executor = node, executor
            self.client: Any = client
            self.request = SetBool.Request()
            for case in self.of('open'):
                case.run()
                self.check_data(case)
            self.run_in_callbacks()
            self.run_in_coroutines()
        finally:
            node.destroy_node()
            rclpy.shutdown()

    def check_data(self, case: Case) -> None:
        """Call the program beside this one, and look at its answer."""
        if ended_in_child:
            return
        future = self.client.call_async(self.request)
        self.executor.spin_until_future_complete(future, timeout_sec=LIMIT_S)
        self.calls += 1
        if not future.done():
            case.complain('no answer from the program beside this one')
        elif future.result().message != str(self.calls):
            case.complain(f'the answer is {future.result().message} and not {self.calls}')

    def run_in_callbacks(self) -> None:
        """Run cases in the callback of a timer."""
        for case in self.of('in a callback'):
            self.run_in_callback(case)
            self.check_data(case)

    def run_in_callback(self, case: Case) -> None:
        """Run one case in the callback of a timer."""
        from rclpy.task import Future

        over: Any = Future()

        def run() -> None:
            timer.cancel()
            case.run()
            over.set_result(None)

        timer = self.node.create_timer(0.001, run)
        self.executor.spin_until_future_complete(over, timeout_sec=3 * LIMIT_S)
        if not ended_in_child:
            self.node.destroy_timer(timer)

    def run_in_coroutines(self) -> None:
        """Run cases in coroutines of the executor; another one waits for a timer meanwhile."""
        from rclpy.task import Future

        waited: Any = Future()

        async def wait() -> str:
            return str(await waited)

        waiting = self.executor.create_task(wait)
        for case in self.of('in a coroutine'):

            async def run(case: Case = case) -> None:
                case.run()

            self.executor.spin_until_future_complete(self.executor.create_task(run), timeout_sec=3 * LIMIT_S)
            if ended_in_child:
                return
            self.check_data(case)
        waited.set_result('the end')
        self.executor.spin_until_future_complete(waiting, timeout_sec=LIMIT_S)
        if not ended_in_child and waiting.result() != 'the end':
            failures.append('the coroutine that waited was cancelled')

    def check_left(self) -> None:
        """Look for what is left after shutdown."""
        for thread in set(threading.enumerate()) - self.threads:
            thread.join(LIMIT_S)
            if thread.is_alive():
                failures.append(f'a thread is left: {thread.name}')
        if (sockets := child.network_sockets()) != self.sockets:
            failures.append(f'sockets are left: {sockets}')


def children() -> list[str]:
    """Return what runs below this process, multiprocessing's own two aside."""
    found = []
    for task in Path('/proc/self/task').iterdir():
        with suppress(FileNotFoundError):  # a thread or a child that ends at this moment
            for pid in task.joinpath('children').read_text().split():
                command = Path('/proc', pid, 'cmdline').read_bytes().replace(b'\0', b' ').decode()
                if 'multiprocessing.forkserver' not in command and 'resource_tracker' not in command:
                    found.append(f'{pid} {command}')
    return found


def chosen(arguments: list[str]) -> list[tuple[str, str, str]]:
    """Return the cases that are asked for."""
    if arguments[0] == 'all':
        return list(product(WAYS, TIMES, ENDS))
    first = int(arguments[1])
    return [
        (way, time, end)
        for (i, way), (j, time), (k, end) in product(*map(enumerate, (WAYS, TIMES, ENDS)))
        if (i + j + first) % len(ENDS) == k
    ]


def main() -> int:
    """Run the cases; returns in forked children, too."""
    cases = chosen(sys.argv[1:])
    faulthandler.register(signal.SIGALRM, chain=True)  # shows where it hangs, and ends the program
    files.update(child.open_files(16))
    Parent(cases).run()
    if ended_in_child:
        return 0
    failures.extend(f'a process is left: {each}' for each in children())
    print('--', *failures, f'{len(cases)} cases', *([] if failures else ['good']), sep='\n', flush=True)
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
