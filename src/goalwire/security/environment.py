"""The variables that say which identity a program has.

    GOALWIRE_SECURITY=DIR:NAME        a keystore, and an identity in it
    ROS_SECURITY_ENABLE=true          ROS 2's own: with
    ROS_SECURITY_KEYSTORE=DIR         the keystore, and
    ROS_SECURITY_STRATEGY=Enforce     a program without an identity ends (else it runs without security)
    ROS_SECURITY_ENCLAVE_OVERRIDE     the enclave, in place of `--ros-args --enclave`

The enclave `/robot/arm` is the identity `robot.arm`. Sources: rcl security.c; ROS 2's design of enclaves.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from goalwire.errors import SecurityError
from goalwire.records import record

VARIABLE = 'GOALWIRE_SECURITY'


@record
class Chosen:
    """The identity that a program has."""

    folder: Path
    name: str

    @property
    def identity_path(self) -> Path:
        """The file with its key and certificates."""
        return self.folder / 'identities' / f'{self.name}.pem'


def keystore_folder(env: Mapping[str, str] = os.environ) -> Path | None:
    """Return the keystore that the environment names; None if it names none."""
    folder = env.get(VARIABLE, '').rpartition(':')[0] or env.get('ROS_SECURITY_KEYSTORE', '')
    return Path(folder) if folder else None


def choose_identity(enclave: str = '/', env: Mapping[str, str] = os.environ) -> Chosen | None:
    """Return the identity of this program; None if it runs without security.

    Raises SecurityError if the identity that is asked for is not there: then nothing may run unprotected.
    """
    text = env.get(VARIABLE, '')
    if text:
        folder, _, name = text.rpartition(':')
        if not folder or not name or '/' in name:
            raise SecurityError(
                f"{VARIABLE} is '{text}'; set it to DIR:NAME, a keystore and an identity in it"
            )
        return _require(Chosen(Path(folder), name), VARIABLE)
    if env.get('ROS_SECURITY_ENABLE', '').lower() != 'true':
        return None
    folder = env.get('ROS_SECURITY_KEYSTORE', '')
    if not folder:
        raise SecurityError(
            'ROS_SECURITY_ENABLE is true, and ROS_SECURITY_KEYSTORE is not set: set it to a keystore'
        )
    path = env.get('ROS_SECURITY_ENCLAVE_OVERRIDE') or enclave
    chosen = Chosen(Path(folder), path.strip('/').replace('/', '.'))
    if env.get('ROS_SECURITY_STRATEGY') == 'Enforce' or chosen.identity_path.is_file():
        return _require(chosen, f"enclave '{path}'")
    return None


def _require(chosen: Chosen, source: str) -> Chosen:
    if not chosen.name or not chosen.identity_path.is_file():
        raise SecurityError(
            f"{source}: there is no identity '{chosen.name}' in the keystore '{chosen.folder}'; "
            f'see: goalwire secure list -k {chosen.folder}'
        )
    return chosen
