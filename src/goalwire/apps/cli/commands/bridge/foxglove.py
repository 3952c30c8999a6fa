"""goalwire bridge foxglove: Foxglove and clients of its SDK, until Ctrl-C."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable

import goalwire
from goalwire.apps.bridge.settings import Settings
from goalwire.apps.cli.commands.bridge.options import add_options, missing_package, run_bridge
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the options."""
    add_options(parser, 8765)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Serve clients."""
    try:
        from goalwire.apps.bridge.foxglove.frames import SUBPROTOCOLS
        from goalwire.apps.bridge.foxglove.session import FoxgloveSession
        from goalwire.apps.bridge.server import serve_clients
    except ModuleNotFoundError as error:
        raise missing_package(error) from None

    async def serve(node: goalwire.Node, settings: Settings, ready: Callable[[str], object]) -> None:
        await serve_clients(node, settings, FoxgloveSession, ready, SUBPROTOCOLS)

    return run_bridge('foxglove', arguments, output, serve)
