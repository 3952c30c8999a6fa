"""goalwire secure export, import, dds and config: what other machines and programs get from a keystore."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import (
    add_keystore_argument,
    add_life_argument,
    find_folder,
    open_keystore,
    require_cryptography,
)
from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.keystore import Keystore


def add_export_identity_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure export`."""
    parser.add_argument('name', metavar='NAME', help='The identity')
    parser.add_argument(
        'file',
        metavar='FILE',
        nargs='?',
        type=Path,
        help='Default: NAME.identity; a name that ends in .p12 is for browsers',
    )
    parser.add_argument(
        '--authority',
        metavar='URL',
        default='',
        help="Where its certificate is renewed: the address of 'secure authority' (e.g. https://192.168.0.7:7449)",
    )
    add_keystore_argument(parser)


def export_identity(arguments: Namespace, output: Output) -> None:
    """Write the archive."""
    keystore = open_keystore(arguments)
    from goalwire.security.bundle import export

    path = arguments.file or Path(f'{arguments.name}.identity')
    if path.suffix == '.p12':
        _export_for_browser(keystore, arguments.name, path, output)
        return
    export(keystore, arguments.name, path, arguments.authority)
    output.show(
        {'name': arguments.name, 'file': str(path)},
        f'{path} holds the key of {arguments.name}: carry it there, and delete it here',
    )


def _export_for_browser(keystore: Keystore, name: str, path: Path, output: Output) -> None:
    """Write the certificate for a browser, and print the password that the browser asks for."""
    from goalwire.security.bundle import export_for_browser

    password = export_for_browser(keystore, name, path)
    output.show(
        {'name': name, 'file': str(path), 'password': password},
        f'{path} holds the key of {name}; the browser asks for its password: {password}',
    )


def add_take_identity_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure import`."""
    parser.add_argument('file', metavar='FILE', type=Path, help="The file that 'secure export' has written")
    parser.add_argument(
        'folder', metavar='DIR', type=Path, help='The keystore on this machine; made if it does not exist'
    )


def take_identity(arguments: Namespace, output: Output) -> None:
    """Import the archive."""
    require_cryptography()
    from goalwire.security.bundle import import_identity

    name = import_identity(arguments.folder, arguments.file)
    # With the whole path, so that the variable also holds in programs that start in another folder.
    whole = arguments.folder.absolute()
    output.show(
        {'name': name, 'keystore': str(arguments.folder)},
        f'{name} is in {arguments.folder}; next: export GOALWIRE_SECURITY={whole}:{name}',
    )


def add_write_dds_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure dds`."""
    parser.add_argument('folder', metavar='DIR', type=Path, help='The folder for ROS_SECURITY_KEYSTORE')
    add_life_argument(parser)
    add_keystore_argument(parser)


def write_dds(arguments: Namespace, output: Output) -> None:
    """Write the enclaves, and tell what DDS cannot express. Raises SecurityError."""
    keystore = open_keystore(arguments)
    from goalwire.security.dds_keystore import write_dds_keystore
    from goalwire.security.dds_permissions import inexpressible
    from goalwire.security.policy_file import load_policy

    enclaves = write_dds_keystore(keystore, arguments.folder, arguments.days)
    for sentence in inexpressible(load_policy(keystore.policy_path)):
        tell(sentence)
    for enclave in enclaves:
        output.show(
            {'enclave': enclave, 'keystore': str(arguments.folder)},
            f'{enclave} is in {arguments.folder}: export ROS_SECURITY_KEYSTORE={arguments.folder}',
        )


def add_print_settings_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure config`."""
    parser.add_argument('what', choices=['router', 'session'], help='Whose settings')
    parser.add_argument('name', metavar='NAME', help='The identity of the router or session')
    parser.add_argument('--router-host', metavar='HOST', default='localhost', help='Where the router is')
    parser.add_argument('--port', metavar='N', type=port_to_name, default=7447, help="The router's TCP port")
    add_keystore_argument(parser)


def print_settings(arguments: Namespace, output: Output) -> Outcome:
    """Print the settings as JSON, which rmw_zenoh reads as json5 (ZENOH_ROUTER_CONFIG_URI and the like)."""
    from goalwire.security.environment import VARIABLE, choose_identity
    from goalwire.security.policy_file import load_policy
    from goalwire.transport.zenoh.router_rules import inexpressible
    from goalwire.transport.zenoh.settings import secured_rmw_zenoh

    folder = find_folder(arguments).resolve()
    identity = choose_identity(env={VARIABLE: f'{folder}:{arguments.name}'})
    assert identity is not None
    if arguments.what == 'router':
        settings = secured_rmw_zenoh.router_settings(identity, arguments.port)
        for each in inexpressible(load_policy(folder / 'policy.toml')):
            tell(each)
    else:
        settings = secured_rmw_zenoh.session_settings(
            identity, f'tls/{arguments.router_host}:{arguments.port}'
        )
    output.block(json.dumps(settings, indent=None if output.json else 2) + os.linesep, end='')
    return Outcome.OK
