"""goalwire secure config: prints settings for rmw_zenoh's router and sessions, from keystore and policy."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, find_folder
from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure config`."""
    parser.add_argument('what', choices=['router', 'session'], help='Whose settings')
    parser.add_argument('name', metavar='NAME', help='The identity of the router or session')
    parser.add_argument('--router-host', metavar='HOST', default='localhost', help='Where the router is')
    parser.add_argument('--port', metavar='N', type=port_to_name, default=7447, help="The router's TCP port")
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print the settings as JSON, which rmw_zenoh reads as json5 (ZENOH_ROUTER_CONFIG_URI and the like)."""
    from goalwire.security.environment import VARIABLE, choose_identity
    from goalwire.security.policy_file import load_policy
    from goalwire.transport.zenoh.router_rules import inexpressible
    from goalwire.transport.zenoh.settings import secured

    folder = find_folder(arguments).resolve()
    identity = choose_identity(env={VARIABLE: f'{folder}:{arguments.name}'})
    assert identity is not None
    if arguments.what == 'router':
        settings = secured.router_settings(identity, arguments.port)
        for each in inexpressible(load_policy(folder / 'policy.toml')):
            tell(each)
    else:
        settings = secured.session_settings(identity, f'tls/{arguments.router_host}:{arguments.port}')
    output.block(json.dumps(settings, indent=None if output.json else 2) + os.linesep, end='')
    return Outcome.OK
