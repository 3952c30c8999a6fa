"""goalwire bridge rosbridge: clients of the rosbridge protocol, until Ctrl-C."""

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
    add_options(parser, 9090)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Serve clients."""
    try:
        import cbor2  # noqa: F401 - named here, since clients ask for it later
        import PIL  # noqa: F401

        from goalwire.apps.bridge.rosbridge.session import RosbridgeSession
        from goalwire.apps.bridge.server import serve_clients
    except ModuleNotFoundError as error:
        raise missing_package(error) from None

    async def serve(node: goalwire.Node, settings: Settings, ready: Callable[[str], object]) -> None:
        await serve_clients(node, settings, RosbridgeSession, ready)

    return run_bridge('rosbridge', arguments, output, serve)
