"""goalwire secure check: finds the faults of a keystore, and advises on each."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, open_keystore
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.errors import SecurityError

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure check`."""
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Check the keystore; the outcome is FAILED if a finding is an error."""
    keystore = open_keystore(arguments)
    from goalwire.security.checking import Finding, check
    from goalwire.security.policy_file import load_policy
    from goalwire.transport.zenoh.router_rules import inexpressible

    findings = check(keystore)
    with suppress(SecurityError):  # The findings already contain the error of an unreadable policy.
        policy = load_policy(keystore.policy_path)
        findings += [Finding(each, is_error=False) for each in inexpressible(policy)]
    for each in findings:
        if output.json:
            output.data({'severity': each.severity, 'problem': each.problem})
        else:
            output.line(f'{each.severity}: {each.problem}', style='red' if each.is_error else 'yellow')
    if not findings and not output.json:
        output.line(f'{keystore.path}: nothing is wrong')
    return Outcome.FAILED if any(each.is_error for each in findings) else Outcome.OK
