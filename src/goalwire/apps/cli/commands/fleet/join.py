"""goalwire fleet join: writes the settings of a robot's router, or of an operator's programs."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.fleet.writing import (
    PORT,
    add_writing_arguments,
    address,
    open_identity,
    write_settings,
)
from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.rules.names.robots import check_pattern

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _rate(text: str) -> tuple[str, float]:
    name, _, rate = text.partition('=')
    try:
        number = float(rate)
    except ValueError:
        number = 0.0
    if not name or not 0 < number < 10_000:
        raise ArgumentTypeError(f"'{text}' is not a topic and its rate in Hz: write camera/image=2")
    return _name(name), number


def _name(text: str) -> str:
    """Read a name below the robot's namespace, or a pattern of names."""
    name = text.strip('/')
    if not name or not name.replace('/', '').replace('*', '').replace('_', '').isalnum():
        raise ArgumentTypeError(f"'{text}' is not a name on the robot, or a pattern such as 'camera/*'")
    return name


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet join`."""
    add_writing_arguments(parser)
    parser.add_argument(
        '--router',
        metavar='ADDRESS',
        type=address,
        action='append',
        required=True,
        help='The router to dial, HOST or HOST:PORT: that of the site, or of the cloud; may be repeated',
    )
    parser.add_argument(
        '--port',
        metavar='N',
        type=port_to_name,
        default=PORT,
        help="The port where the robot's programs meet",
    )
    parser.add_argument(
        '--allow',
        metavar='NAME',
        type=_name,
        action='append',
        default=[],
        help='What may leave the robot, below its namespace (default: everything); may be repeated',
    )
    parser.add_argument(
        '--rate',
        metavar='NAME=HZ',
        type=_rate,
        action='append',
        default=[],
        help='The highest rate at which a topic leaves the robot; may be repeated',
    )
    parser.add_argument(
        '--background',
        metavar='NAME',
        type=_name,
        action='append',
        default=[],
        help='A topic that gives way to all others on the link; may be repeated',
    )


def run(arguments: Namespace, output: Output) -> Outcome:
    """Write settings: for a robot those of a router, for a person or a program those of a session."""
    from goalwire.transport.zenoh.settings import fleet, secured

    _, kind, identity = open_identity(arguments)
    if kind == 'router':
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{arguments.name}' is a router, and not a robot or an operator",
            f'see: goalwire fleet init {arguments.name} --router ADDRESS',
        )
    if kind != 'robot':
        settings = secured.session_settings(identity, arguments.router[0])
        start = 'export ZENOH_SESSION_CONFIG_URI={file}; goalwire fleet list'
        return write_settings(arguments, settings, start, output)
    try:
        robot = check_pattern(arguments.name, is_name=True)
    except ValueError as error:
        raise CommandError(
            Outcome.BAD_VALUE, str(error), 'name the robot as its namespace is named'
        ) from None
    uplink = fleet.Uplink(tuple(arguments.allow), dict(arguments.rate), tuple(arguments.background))
    settings = fleet.robot_router(identity, robot, arguments.port, arguments.router, uplink)
    start = 'carry it to the robot, and run there: ZENOH_ROUTER_CONFIG_URI={file} goalwire router'
    return write_settings(arguments, settings, start, output)
