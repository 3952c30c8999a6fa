"""ros2 service call: one call, one again and again, or many with their latencies."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from math import ceil
from time import perf_counter
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.framework import lookup, values
from goalwire.apps.cli.framework.live import live, refuse_other_type, tell_types_ourselves, types_there
from goalwire.apps.cli.framework.messages import as_dict
from goalwire.apps.cli.framework.named import SERVICES
from goalwire.apps.cli.framework.numbers import count, positive
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

LOOK_S = 0.3
"""How long a server may take before it is said that it is waited for."""
PATIENCE_S = 5.0
"""How long a service may take to appear where no `--timeout` says it."""
_BAR = 40
"""Characters of the longest bar of a histogram."""


def call_arguments(parser: ArgumentParser) -> None:
    """Add what `service call` takes after the name."""
    parser.add_argument(
        'words',
        nargs='*',
        metavar='[TYPE] [VALUES]',
        help=f'Type of the service, which may be left out where the graph knows it; then {values.HELP}',
    )
    parser.add_argument('--stdin', action='store_true', help='Read the values from standard input')
    parser.add_argument(
        '-r', '--rate', metavar='N', type=positive, help='Call again and again, N times a second'
    )
    parser.add_argument(
        '--timeout',
        metavar='S',
        type=positive,
        help=f'Seconds that a call may take, with the wait for the server; without it the server must appear '
        f'within {PATIENCE_S:.0f} s, and its answer may take any time',
    )
    parser.add_argument(
        '--retry',
        metavar='N',
        type=count,
        default=1,
        help='Send the request up to N times where no answer comes: for services that may be called twice',
    )
    parser.add_argument(
        '--repeat', metavar='N', type=count, help='Call N times, and show how long the answers took'
    )


class _Call:
    """What is called, once the type is known."""

    def __init__(
        self,
        name: str,
        cls: Any,
        type_name: str,
        request: Any,
        set_stamps: list[Callable[[Any], None]],
        arguments: Namespace,
    ) -> None:
        self.name = name
        self.cls = cls
        self.type_name = type_name
        self.request = request
        self.set_stamps = set_stamps
        self.arguments = arguments

    async def perform(self, node: goalwire.Node, output: Output) -> Outcome:
        client = await self._client(node, output)
        if self.arguments.repeat is not None:
            return await self._measure(client, node, output)
        while True:
            began = perf_counter()
            await self._call(client, node, output)
            if self.arguments.rate is None:
                return Outcome.OK
            await asyncio.sleep(max(0.0, began + 1.0 / self.arguments.rate - perf_counter()))

    async def _client(self, node: goalwire.Node, output: Output) -> goalwire.Client[Any, Any]:
        """Return a client whose server is there."""
        tell_types_ourselves()
        retry = goalwire.Retry(attempts=self.arguments.retry) if self.arguments.retry > 1 else None
        client = node.client(self.cls, self.name, timeout=self.arguments.timeout, retry=retry)
        try:
            await client.wait_for_server(timeout=LOOK_S)
        except goalwire.NoServerError:
            refuse_other_type(self.name, self.type_name, types_there(node, EndpointKind.SERVICE, self.name))
            if not output.json:
                output.block('waiting for service to become available...')
            await client.wait_for_server(timeout=self.arguments.timeout or PATIENCE_S)
        return client

    def _stamp(self, node: goalwire.Node) -> None:
        """Set the times that were given as 'now'."""
        for set_stamp in self.set_stamps:
            set_stamp(node.clock.now().to_msg())

    async def _call(self, client: goalwire.Client[Any, Any], node: goalwire.Node, output: Output) -> None:
        self._stamp(node)
        if not output.json:
            output.block(f'requester: making request: {self.request!r}\n')
        began = perf_counter()
        response = await client.call(self.request)
        took = perf_counter() - began
        if output.json:
            output.data(
                {
                    'name': self.name,
                    'type': self.type_name,
                    'request': as_dict(self.request),
                    'response': as_dict(response),
                    'seconds': took,
                }
            )
        else:
            output.block(f'response:\n{response!r}\n')

    async def _measure(
        self, client: goalwire.Client[Any, Any], node: goalwire.Node, output: Output
    ) -> Outcome:
        wanted, rate = self.arguments.repeat, self.arguments.rate
        took: list[float] = []
        failures: list[goalwire.CallError] = []
        start = perf_counter()
        for number in range(wanted):
            self._stamp(node)
            began = perf_counter()
            try:
                await client.call(self.request)
                took.append(perf_counter() - began)
            except goalwire.CallError as error:
                failures.append(error)
            if rate is not None and number < wanted - 1:
                await asyncio.sleep(max(0.0, start + (number + 1) / rate - perf_counter()))
        _show_latencies(self.name, took, len(failures), perf_counter() - start, output)
        if failures:
            raise failures[-1]
        return Outcome.OK


def _show_latencies(name: str, took: list[float], failed: int, lasted: float, output: Output) -> None:
    took = sorted(took)
    shares = {f'p{share}': percentile(took, share) for share in (50, 90, 95, 99)} if took else {}
    if output.json:
        extremes = {'min': took[0], 'max': took[-1]} if took else {}
        output.data(
            {
                'name': name,
                'calls': len(took) + failed,
                'answered': len(took),
                'failed': failed,
                'lasted': lasted,
                'seconds': {**extremes, **shares},
                'histogram': [{'below': upper, 'calls': n} for upper, n in histogram(took)],
            }
        )
        return
    output.line(
        f"{len(took) + failed} calls of '{name}' in {lasted:.3f} s: {len(took)} answered, {failed} failed"
    )
    if not took:
        return
    told = {'min': took[0], **shares, 'max': took[-1]}
    output.line('  '.join(f'{title} {milliseconds(seconds)}' for title, seconds in told.items()))
    for line in histogram_lines(took):
        output.line(line)


def percentile(ordered: list[float], share: int) -> float:
    """Return the smallest value that `share` percent of the values do not exceed (nearest rank)."""
    return ordered[max(0, ceil(len(ordered) * share / 100) - 1)]


def histogram(ordered: list[float]) -> list[tuple[float, int]]:
    """Return upper limits (1, 2, 3, 5, 7, 10 … of each power of ten), and how many lie below each.

    Empty limits at both ends are left out.
    """
    found: list[tuple[float, int]] = []
    rest, power = list(ordered), 1e-6
    while rest:
        for step in (1.0, 2.0, 3.0, 5.0, 7.0):
            upper = step * power
            below = sum(1 for each in rest if each < upper)
            rest = rest[below:]
            if below or (found and rest):
                found.append((upper, below))
        power *= 10.0
    return found


def histogram_lines(ordered: list[float]) -> list[str]:
    """Return a histogram drawn for a terminal; there must be values."""
    buckets = histogram(ordered)
    most = max(n for _, n in buckets)
    return [
        f'  < {milliseconds(upper):>10}  {"█" * ceil(_BAR * n / most):{_BAR}}  {n}'.rstrip()
        for upper, n in buckets
    ]


def milliseconds(seconds: float) -> str:
    """Return a time as people read it."""
    return f'{seconds * 1000:.3g} ms' if seconds < 1 else f'{seconds:.3g} s'


def call(arguments: Namespace, output: Output) -> Outcome:
    """Call a service; raises CommandError and goalwire's own errors."""
    name = lookup.full_name(arguments.service_name, 'service')
    type_name, words = lookup.split_type(arguments.words, 'srv')
    if type_name is None:
        name, type_name = SERVICES.name_and_type(arguments)
    cls = lookup.interface(type_name)
    given = values.read_values(words, cls.Request, stdin=arguments.stdin)
    request = cls.Request()
    set_stamps = values.fill(request, given, type_name)
    what = _Call(name, cls, type_name, request, set_stamps, arguments)
    return live(lambda node: what.perform(node, output))
