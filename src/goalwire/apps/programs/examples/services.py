"""The minimal service and its clients: add_two_ints of the demo nodes, under other names."""

from __future__ import annotations

from collections.abc import Sequence

from example_interfaces.srv import AddTwoInts

from goalwire.apps.programs.demo_nodes.add_two_ints import AddTwoIntsServer, call_once
from goalwire.apps.programs.running import spin

A, B = 41, 1


def serve(args: Sequence[str] | None = None) -> int:
    """Run the service."""
    return spin(lambda: AddTwoIntsServer('minimal_service'), args)


def ask(args: Sequence[str] | None = None) -> int:
    """Wait for the service, ask for 41 + 1 and log the answer; returns the exit code."""
    said = f'Result of add_two_ints: for {A} + {B} = {{sum}}'
    return call_once('minimal_client', AddTwoInts.Request(a=A, b=B), said, args)
