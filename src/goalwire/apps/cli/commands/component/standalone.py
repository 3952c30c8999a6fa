"""ros2 component standalone: runs a component in a container of its own, until Ctrl-C."""

from __future__ import annotations

import asyncio
import signal
import sys
from argparse import ArgumentParser, Namespace
from contextlib import suppress
from typing import TYPE_CHECKING
from uuid import uuid4

import goalwire
from goalwire.apps.cli.commands.component.loading import add_component_arguments, load_component
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_KILL = getattr(signal, 'SIGKILL', signal.SIGTERM)
OWN_END_S = 0.5
"""Seconds that a container may take to end after Ctrl-C before this command sends it SIGINT."""
END_S = 10.0
"""Seconds that the container may take to end after SIGINT before it is killed."""


def arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `component standalone`."""
    add_graph_arguments(parser)
    add_component_arguments(parser)
    parser.add_argument(
        '-c', '--container-node-name', help='Name of the container node (default: a name of its own)'
    )


def run(given: Namespace, output: Output) -> Outcome:
    """Start a container, have it load the component, and wait for its end."""
    name = given.container_node_name or f'standalone_container_{uuid4().hex[:12]}'
    command = [*_container_command(given), '--ros-args', '-r', f'__node:={name}']

    async def perform(node: goalwire.Node) -> Outcome:
        container = await asyncio.create_subprocess_exec(*command)
        try:
            loading = asyncio.create_task(load_component(node, f'/{name}', given))
            ended = asyncio.create_task(container.wait())
            await asyncio.wait({loading, ended}, return_when=asyncio.FIRST_COMPLETED)
            if not loading.done():
                loading.cancel()
                raise CommandError(
                    Outcome.FAILED, f'the container has ended with code {ended.result()} before it loaded'
                )
            response = await loading
            output.block(
                f"Loaded component {response.unique_id} into '/{name}' container node as "
                f"'{response.full_node_name}'"
            )
            return Outcome.OK if await ended == 0 else Outcome.FAILED
        finally:
            await _end(container)

    return live(perform)


async def _end(container: asyncio.subprocess.Process) -> None:
    """Wait until a container ends; send it SIGINT, and then SIGKILL, if it takes too long.

    A Ctrl-C on the terminal has reached the container, too, so it may end without a signal from here.
    """
    for wait_s, number in ((OWN_END_S, signal.SIGINT), (END_S, _KILL)):
        with suppress(TimeoutError):
            async with asyncio.timeout(wait_s):
                await container.wait()
            return
        with suppress(ProcessLookupError):
            container.send_signal(number)
    await container.wait()


def _container_command(given: Namespace) -> list[str]:
    """Return the command of a container that can load the component; raises CommandError."""
    from goalwire.errors import LaunchError
    from goalwire.launching.packages import executable, has_component

    if has_component(given.package_name, given.plugin_name):
        return [sys.executable, '-m', 'rclpy_components.component_container']
    try:
        return [executable('rclcpp_components', 'component_container')]
    except LaunchError:
        raise CommandError(
            Outcome.NOT_FOUND,
            f"there is no component '{given.plugin_name}' of the package '{given.package_name}' in Python, "
            'and no container for components in C++ is installed',
            'see: ros2 component types',
        ) from None
