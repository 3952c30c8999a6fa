"""goalwire fleet init and join: the settings of routers, and of operators' programs."""

from __future__ import annotations

import json
import re
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, find_folder, open_keystore
from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.rules.names.robots import check_pattern
from goalwire.security.environment import Chosen

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.keystore import Keystore
    from goalwire.transport.zenoh.settings.values import Settings

PORT = 7447
_ADDRESS = re.compile(r'(?:tls/)?(?P<host>\[[^][\s/]+\]|[^][\s/:]+)(?::(?P<port>[0-9]{1,5}))?')
"""HOST is a name or an address; one of IPv6 has brackets, since its colons would be taken for a port's."""


def add_write_router_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet init`."""
    add_writing_arguments(parser)
    parser.add_argument(
        '--listen',
        metavar='ADDRESS',
        type=address,
        action='append',
        help=f'Where robots and operators come: HOST:PORT (default: port {PORT} of every address)',
    )
    parser.add_argument(
        '--router',
        metavar='ADDRESS',
        type=address,
        action='append',
        default=[],
        help='The router above, HOST or HOST:PORT: that of the cloud; a cloud has none',
    )


def write_router(arguments: Namespace, output: Output) -> Outcome:
    """Write the settings of a router, which list the robots and the other identities of the keystore."""
    from goalwire.security.certificates import kind_of
    from goalwire.transport.zenoh.settings import built_in, fleet

    keystore, kind, identity = open_identity(arguments)
    if kind != 'router':
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{arguments.name}' is a {kind}, and not a router",
            f'see: goalwire secure add NAME --router, or: goalwire fleet join {arguments.name}',
        )
    revoked = keystore.list_revoked()
    kinds = {name: kind_of(keystore.identity(name).certificate) for name in keystore.names()}
    there = {name: each for name, each in kinds.items() if name not in revoked and name != arguments.name}
    robots = [name for name, each in there.items() if each == 'robot']
    settings = fleet.site_router(
        identity,
        arguments.listen or [str(each) for each in built_in.everywhere(PORT)],
        arguments.router,
        robots,
        [name for name, each in there.items() if each != 'robot'],
    )
    if len(robots) * fleet.KEYS_OF_A_HUMANOID > fleet.MOST_KEYS:
        tell(
            f'{len(robots)} robots: a link between routers carries {fleet.MOST_KEYS:,} keys, '
            f"and a robot with all of the humanoid's names has {fleet.KEYS_OF_A_HUMANOID}. "
            'Choose the names that leave each robot: goalwire fleet join ROBOT --allow NAME'
        )
    start = 'carry it to its machine, and run there: ZENOH_ROUTER_CONFIG_URI={file} goalwire router'
    return write_settings(arguments, settings, start, output)


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


def add_write_member_arguments(parser: ArgumentParser) -> None:
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


def write_member(arguments: Namespace, output: Output) -> Outcome:
    """Write settings: for a robot those of a router, for a person or a program those of a session."""
    from goalwire.transport.zenoh.settings import fleet, secured_rmw_zenoh

    _, kind, identity = open_identity(arguments)
    if kind == 'router':
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{arguments.name}' is a router, and not a robot or an operator",
            f'see: goalwire fleet init {arguments.name} --router ADDRESS',
        )
    if kind != 'robot':
        settings = secured_rmw_zenoh.session_settings(identity, arguments.router[0])
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


def address(text: str) -> str:
    """Read the address of a router: HOST, HOST:PORT or tls/HOST:PORT. Raises ArgumentTypeError."""
    found = _ADDRESS.fullmatch(text)
    if found is None or not 0 < int(found['port'] or PORT) < 65_536:
        raise ArgumentTypeError(f"'{text}' is not the address of a router: write HOST or HOST:PORT")
    return f'tls/{found["host"]}:{found["port"] or PORT}'


def add_writing_arguments(parser: ArgumentParser) -> None:
    """Add the arguments for the identity, its keystore, and the file of its settings."""
    parser.add_argument('name', metavar='NAME', help='The identity in the keystore')
    add_keystore_argument(parser)
    parser.add_argument(
        '--keys-there',
        metavar='DIR',
        type=Path,
        help="The keystore's folder on the machine that gets the settings (default: the same as here)",
    )
    parser.add_argument(
        '-o', '--output', metavar='FILE', type=Path, help='The file to write (default: NAME.json5)'
    )
    parser.add_argument('--force', action='store_true', help='Replace the file if it is there')


def open_identity(arguments: Namespace) -> tuple[Keystore, str, Chosen]:
    """Return the keystore, the kind of the identity, and the identity with its folder on its own machine.

    Raises CommandError, SecurityError.
    """
    from goalwire.security.certificates import kind_of

    keystore = open_keystore(arguments)
    kind = kind_of(keystore.identity(arguments.name).certificate)
    there = arguments.keys_there or find_folder(arguments).resolve()
    return keystore, kind, Chosen(there, arguments.name)


def write_settings(arguments: Namespace, settings: Settings, start: str, output: Output) -> Outcome:
    """Write the settings to a file, and print `start`, which tells how to use them. Raises CommandError.

    {file} in `start` stands for the path of the file.
    """
    path: Path = arguments.output or Path(f'{arguments.name}.json5')
    try:
        with path.open('w' if arguments.force else 'x', encoding='utf-8') as file:
            file.write(json.dumps(settings, indent=2) + '\n')
    except FileExistsError:
        raise CommandError(
            Outcome.REFUSED, f"the file '{path}' is there already", 'replace it with --force'
        ) from None
    except OSError as error:
        raise CommandError(Outcome.FAILED, f"'{path}' cannot be written: {error.strerror}") from None
    next_step = start.format(file=path)
    output.show({'file': str(path), 'next': next_step}, f'{path} is written; next: {next_step}')
    return Outcome.OK
