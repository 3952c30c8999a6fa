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
from goalwire.apps.cli.framework.entity_kinds import SERVICES
from goalwire.apps.cli.framework.live import live, refuse_other_type, tell_types_ourselves, types_there
from goalwire.apps.cli.framework.numbers import count, positive
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.observe.latencies import Latencies, show_seconds
from goalwire.observe.messages import as_dict
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

LOOK_S = 0.3
"""Seconds of waiting for a server before the command says that it waits."""
PATIENCE_S = 5.0
"""Seconds that a service may take to appear, without `--timeout`."""
_BAR = 40
"""Characters of the longest bar of a histogram."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `service call`."""
    SERVICES.name_argument(parser)
    parser.add_argument(
        'words',
        nargs='*',
        metavar='[TYPE] [VALUES]',
        help=f'Type of the service, which may be left out if the graph knows it; then {values.HELP}',
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
        help='Send the request up to N times if no answer comes: for services that may be called twice',
    )
    parser.add_argument(
        '--repeat', metavar='N', type=count, help='Call N times, and show how long the answers took'
    )


class _Call:
    """The calls of one service whose type is known: one, periodic ones, or many with their latencies."""

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
        """Return a client once its server is there."""
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
        """Set the fields that the user gave as 'now' to the present time."""
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
        latencies = Latencies(kept=wanted)
        failure: goalwire.CallError | None = None
        start = perf_counter()
        for number in range(wanted):
            self._stamp(node)
            began = perf_counter()
            try:
                await client.call(self.request)
                latencies.note(perf_counter() - began)
            except goalwire.CallError as error:
                latencies.failed += 1
                failure = error
            if rate is not None and number < wanted - 1:
                await asyncio.sleep(max(0.0, start + (number + 1) / rate - perf_counter()))
        _show_latencies(self.name, latencies, perf_counter() - start, output)
        if failure is not None:
            raise failure
        return Outcome.OK


def _show_latencies(name: str, latencies: Latencies, lasted: float, output: Output) -> None:
    answered, failed = latencies.number, latencies.failed
    shares = [('min', 0), *((f'p{share}', share) for share in (50, 90, 95, 99)), ('max', 100)]
    seconds = {title: latencies.percentile(share / 100) for title, share in shares if answered}
    if output.json:
        output.data(
            {
                'name': name,
                'calls': answered + failed,
                'answered': answered,
                'failed': failed,
                'lasted': lasted,
                'seconds': seconds,
                'histogram': [{'below': upper, 'calls': n} for upper, n in latencies.histogram()],
            }
        )
        return
    output.line(
        f"{answered + failed} calls of '{name}' in {lasted:.3f} s: {answered} answered, {failed} failed"
    )
    if not answered:
        return
    output.line('  '.join(f'{title} {show_seconds(each)}' for title, each in seconds.items()))
    for line in histogram_lines(latencies):
        output.line(line)


def histogram_lines(latencies: Latencies) -> list[str]:
    """Return a histogram drawn for a terminal."""
    buckets = latencies.histogram()
    most = max((n for _, n in buckets), default=0)
    return [
        f'  < {show_seconds(upper):>10}  {"█" * ceil(_BAR * n / most):{_BAR}}  {n}'.rstrip()
        for upper, n in buckets
    ]


def run(arguments: Namespace, output: Output) -> Outcome:
    """Call a service; raises CommandError and goalwire's own errors."""
    name = lookup.full_name(arguments.service_name, 'service')
    type_name, words = lookup.split_type(arguments.words, 'srv')
    if type_name is None:
        name, type_name = SERVICES.name_and_type(arguments)
    cls = lookup.interface_in_use(type_name)
    given = values.read_values(words, cls.Request, stdin=arguments.stdin)
    request = cls.Request()
    set_stamps = values.fill(request, given, type_name)
    what = _Call(name, cls, type_name, request, set_stamps, arguments)
    return live(lambda node: what.perform(node, output))
