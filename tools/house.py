"""Counts what the house is made of: modules, classes, lines, circles, and what a call and a goal enter.

    python tools/house.py            the figures of this checkout
    python tools/house.py --json     the same, for a comparison

A call and a goal are traced on the memory wire, with client and server in one process on one thread, once
three of each have filled the caches.
"""

from __future__ import annotations

import argparse
import ast
import gc
import json
import os
import re
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / 'src' / 'goalwire'
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
OVERLAY = {file.parent.name for file in (SOURCE / 'overlay').glob('*/__init__.py')}  # the others hold stubs
SMALL_MODULE = 60
FEW_METHODS = 2
ROW = '{:<46}{:>8}'


@dataclass(frozen=True)
class Module:
    """One file of the source."""

    path: Path
    text: str
    tree: ast.Module

    @property
    def name(self) -> str:
        """Its dotted name below goalwire; a package's is its folder's, and goalwire's own is none."""
        parts = self.path.relative_to(SOURCE).with_suffix('').parts
        return '.'.join(part for part in parts if part != '__init__')

    @property
    def folder(self) -> str:
        """The folder that has a floor: below `apps` the application, else the one below goalwire."""
        return floor_of(self.name)

    @property
    def lines(self) -> int:
        """How many lines it has."""
        return self.text.count('\n')


@lru_cache(1)
def modules() -> list[Module]:
    """Return every module of the source, generated stubs aside; they are read once.

    They are a million objects that stay. To look for garbage among them takes twice as long as to read them,
    so Python does not look while they are read, nor among them later.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        found = list(_read_modules())
        gc.freeze()
    finally:
        if was_enabled:
            gc.enable()
    return found


def _read_modules() -> Iterator[Module]:
    for path in sorted(SOURCE.rglob('*.py')):
        if path.is_relative_to(SOURCE / 'prefix'):  # launch files, which are data
            continue
        if path.name == 'standard_hashes.py':  # the build writes it
            continue
        text = path.read_text(encoding='utf-8')
        yield Module(path, text, ast.parse(text))


def shape(house: list[Module]) -> dict[str, int]:
    """Count modules, classes, functions and lines."""
    classes = [node for module in house for node in ast.walk(module.tree) if isinstance(node, ast.ClassDef)]
    functions = [node for module in house for node in ast.walk(module.tree) if isinstance(node, FUNCTIONS)]
    lines = [module.lines for module in house]
    return {
        'modules': len(house),
        'lines': sum(lines),
        'median module, lines': int(statistics.median(lines)),
        f'modules below {SMALL_MODULE} lines': sum(count < SMALL_MODULE for count in lines),
        'classes': len(classes),
        f'classes with at most {FEW_METHODS} methods': sum(_methods(one) <= FEW_METHODS for one in classes),
        'longest function, lines': max(map(_length, functions)),
        'committed stubs, lines': sum(
            (ROOT / path).read_text(encoding='utf-8').count('\n') for path in _committed('*.pyi')
        ),
        'silenced SLF001': sum(silenced_privates(module.text) for module in house),
    }


def _committed(pattern: str) -> list[str]:
    command = ['git', 'ls-files', '--', f'src/{pattern}']
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()


def _methods(node: ast.ClassDef) -> int:
    return sum(isinstance(part, FUNCTIONS) for part in node.body)


def _length(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    return (node.end_lineno or node.lineno) - node.lineno + 1


def silenced_privates(text: str) -> int:
    """Count the lines of a file that read a private attribute with the linter silenced."""
    return len(re.findall(r'# noqa: [^#\n]*SLF001', text))


def circles(house: list[Module]) -> list[list[str]]:
    """Return the groups of files that import each other in a circle.

    Every import counts: one in a function and one for types alone join two files as one at the top does.
    """
    names = {module.name for module in house}
    imports = {module.name: set(_imported(module, names)) for module in house}
    return [sorted(group) for group in _components(imports) if len(group) > 1]


def _imported(module: Module, names: set[str]) -> Iterator[str]:
    """Yield the modules of the house that one imports anywhere in it."""
    for target in imported(ast.walk(module.tree)):
        name = below_goalwire(target)
        if name is not None:
            yield name if name in names else name.rpartition('.')[0]


def imported(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Yield what the import statements among some nodes name: `a.b.c` for `from a.b import c`."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f'{node.module}.{alias.name}' for alias in node.names)


def floor_of(name: str) -> str:
    """Return the folder that has a floor: each application stands on its own."""
    parts = name.split('.')
    return '.'.join(parts[: 2 if parts[0] == 'apps' else 1])


def below_goalwire(target: str) -> str | None:
    """Return the dotted name below goalwire of what is imported; None for what is none of goalwire's."""
    top, _, inner = target.partition('.')
    if top in OVERLAY:
        return f'overlay.{target}'
    return inner if top == 'goalwire' else None


def _components(graph: dict[str, set[str]]) -> list[set[str]]:
    """Return the strongly connected components of a graph: Tarjan's algorithm, on a stack of its own."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    path: list[str] = []
    found: list[set[str]] = []
    for root in graph:
        if root in index:
            continue
        work: list[tuple[str, Iterator[str]]] = []

        def enter(node: str, work: list[tuple[str, Iterator[str]]] = work) -> None:
            index[node] = low[node] = len(index)
            path.append(node)
            work.append((node, iter(sorted(graph[node] & graph.keys()))))

        enter(root)
        while work:
            node, targets = work[-1]
            for target in targets:
                if target not in index:
                    enter(target)
                    break
                if target in path:
                    low[node] = min(low[node], index[target])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    cut = path.index(node)
                    found.append(set(path[cut:]))
                    del path[cut:]
    return found


class Trace:
    """Counts the functions of the house that a piece of work enters."""

    def __init__(self) -> None:
        self.calls = 0
        self.codes: set[CodeType] = set()

    def of(self, work: Callable[[], object]) -> Trace:
        """Do `work` on this thread and count what it enters."""
        sys.setprofile(self._note)
        try:
            work()
        finally:
            sys.setprofile(None)
        return self

    def _note(self, frame: FrameType, event: str, _argument: Any) -> None:
        if event == 'call' and frame.f_code.co_filename.startswith(str(SOURCE)):
            self.calls += 1
            self.codes.add(frame.f_code)

    def figures(self, what: str) -> dict[str, int]:
        """Return the counts, named by what was traced."""
        return {
            f'{what}: calls of functions': self.calls,
            f'{what}: functions entered': len(self.codes),
            f'{what}: modules entered': len({code.co_filename for code in self.codes}),
        }


def traced() -> dict[str, int]:
    """Trace one service call, and one goal with a feedback, a cancellation and its result."""
    os.environ['RMW_IMPLEMENTATION'] = 'goalwire_memory'
    import rclpy
    from example_interfaces.action import Fibonacci
    from rclpy.action import ActionClient, ActionServer, CancelResponse
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node
    from std_srvs.srv import SetBool

    async def count(goal: Any) -> Any:
        goal.publish_feedback(Fibonacci.Feedback(sequence=[0]))
        await fed.pop()
        goal.canceled()
        return Fibonacci.Result(sequence=[0])

    with rclpy.init():
        node, executor = Node('traced'), SingleThreadedExecutor()
        node.create_service(SetBool, 'switch', lambda _request, response: response)
        ActionServer(node, Fibonacci, 'count', count, cancel_callback=lambda _goal: CancelResponse.ACCEPT)
        client = node.create_client(SetBool, 'switch')
        counter = ActionClient(node, Fibonacci, 'count')
        executor.add_node(node)
        client.wait_for_service()
        counter.wait_for_server()
        fed: list[Any] = []

        def call() -> None:
            executor.spin_until_future_complete(client.call_async(SetBool.Request()))

        def goal() -> None:
            cancelled: rclpy.Future[None] = rclpy.Future()
            seen: rclpy.Future[Any] = rclpy.Future()
            fed.append(cancelled)
            sent = counter.send_goal_async(Fibonacci.Goal(order=1), feedback_callback=seen.set_result)
            executor.spin_until_future_complete(sent)
            handle = sent.result()
            assert handle is not None
            executor.spin_until_future_complete(seen)
            executor.spin_until_future_complete(handle.cancel_goal_async())
            cancelled.set_result(None)
            executor.spin_until_future_complete(handle.get_result_async())

        for _ in range(3):
            call()
            goal()
        return Trace().of(call).figures('service call') | Trace().of(goal).figures('goal')


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--json', action='store_true', help='print JSON')
    as_json = parser.parse_args().json
    house = modules()
    rings = circles(house)
    counts = shape(house) | {'circles of files': len(rings), 'files in circles': sum(map(len, rings))}
    figures = counts | traced()
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    for name, figure in figures.items():
        print(ROW.format(name, figure))
    for ring in rings:
        print('circle:', ', '.join(ring))


if __name__ == '__main__':
    main()
