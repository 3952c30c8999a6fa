"""goalwire secure dds: writes a keystore of ROS 2 for DDS Security, with the same policy."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import (
    add_keystore_argument,
    add_life_argument,
    open_keystore,
)
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure dds`."""
    parser.add_argument('folder', metavar='DIR', type=Path, help='The folder for ROS_SECURITY_KEYSTORE')
    add_life_argument(parser)
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Write the enclaves, and tell what DDS cannot express. Raises SecurityError."""
    keystore = open_keystore(arguments)
    from goalwire.security.dds_keystore import write_dds_keystore
    from goalwire.security.dds_permissions import inexpressible
    from goalwire.security.policy_file import load_policy

    enclaves = write_dds_keystore(keystore, arguments.folder, arguments.days)
    for sentence in inexpressible(load_policy(keystore.policy_path)):
        tell(sentence)
    for enclave in enclaves:
        if output.json:
            output.data({'enclave': enclave, 'keystore': str(arguments.folder)})
        else:
            output.line(
                f'{enclave} is in {arguments.folder}: export ROS_SECURITY_KEYSTORE={arguments.folder}'
            )
