"""Looks for faults of a keystore: files that others can read, certificates that expire soon, mistakes in a
policy.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from datetime import timedelta

from goalwire.errors import SecurityError
from goalwire.files import why_others_write
from goalwire.records import record
from goalwire.security import KINDS, certificates, revocation
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Policy, Verb
from goalwire.security.policy_file import load_policy

SOON = timedelta(days=7)
"""A certificate is reported if it expires within this time."""


@record
class Finding:
    """Something in a keystore that is wrong, or soon will be."""

    problem: str
    is_error: bool = True

    @property
    def severity(self) -> str:
        """The severity in a word."""
        return 'error' if self.is_error else 'warning'


def check(keystore: Keystore) -> list[Finding]:
    """Return the faults of a keystore."""
    findings = list(_check_modes(keystore))
    policy = None
    try:
        policy = load_policy(keystore.policy_path)
        keystore.list_revoked()
    except SecurityError as error:
        findings.append(Finding(str(error)))
    if policy is not None:
        findings += _check_policy(policy)
    findings += _check_identities(keystore, policy)
    return findings


def _check_modes(keystore: Keystore) -> Iterator[Finding]:
    """Look for keys that others can read, and for files that others can write."""
    if os.name != 'posix':
        return
    folders = [keystore.path, keystore.path / 'identities']
    for folder in folders:
        why = why_others_write(folder.stat())
        if why:
            yield Finding(f"'{folder}' can be changed by others: {why}; run chmod 700 {folder}")
    names = ('authority', 'site', *(f'identities/{name}' for name in keystore.names()))
    for path in (keystore.path / f'{name}.pem' for name in names):
        if path.exists() and stat.S_IMODE(path.stat().st_mode) & 0o077:
            yield Finding(f"'{path}' can be read by others; run chmod 600 {path}, and renew it")


def _check_policy(policy: Policy) -> Iterator[Finding]:
    if not policy.is_enforced:
        yield Finding('the policy refuses nothing: mode is "audit"', is_error=False)
    for who, grants in policy.grants.items():
        if not any(grant.verb is Verb.RUN for grant in grants):
            yield Finding(
                f'\'{who}\' may not run any node: give it a role with run = ["/name"]', is_error=False
            )


def _check_identities(keystore: Keystore, policy: Policy | None) -> Iterator[Finding]:
    now = certificates.now()
    try:
        trust = keystore.trust()
        revoked = keystore.list_revoked()
    except SecurityError as error:
        yield Finding(str(error))
        return
    if trust.not_valid_after_utc - SOON < now:
        yield Finding(f'the authority ends at {trust.not_valid_after_utc:%Y-%m-%d}: make a new keystore')
    for name in keystore.names():
        try:
            pair = keystore.identity(name)
        except SecurityError as error:
            yield Finding(str(error))
            continue
        certificate = pair.certificate
        end = certificate.not_valid_after_utc
        if not certificates.leads_to(pair.chain, trust):
            yield Finding(f"the certificate of '{name}' is not one of this keystore's authority")
        if certificates.common_name(certificate) != name or certificates.kind_of(certificate) not in KINDS:
            yield Finding(f"the certificate in the file of '{name}' is not one for '{name}'")
        if end < now:
            yield Finding(f"the certificate of '{name}' has expired; run goalwire secure renew {name}")
        elif end - SOON < now:
            yield Finding(
                f"the certificate of '{name}' ends at {end:%Y-%m-%d %H:%M} UTC; "
                f'run goalwire secure renew {name}',
                is_error=False,
            )
        if revocation.is_revoked(revoked, name, certificate.not_valid_before_utc):
            yield Finding(f"'{name}' is revoked")
        if policy is not None and not policy.knows(name):
            yield Finding(f"policy.toml does not name '{name}', so it may do nothing", is_error=False)
