"""goalwire secure check, explain and audit: what is wrong, who may do what, and what was refused."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, find_folder, open_keystore
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.errors import SecurityError
from goalwire.security.policy import MISSIONS, STOP, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the argument of `secure check`."""
    add_keystore_argument(parser)


def check_keystore(arguments: Namespace, output: Output) -> Outcome:
    """Check the keystore; the outcome is FAILED if a finding is an error."""
    keystore = open_keystore(arguments)
    from goalwire.security.keystore_check import Finding, check
    from goalwire.security.policy_file import load_policy
    from goalwire.transport.zenoh.router_rules import inexpressible

    findings = check(keystore)
    with suppress(SecurityError):  # The findings already contain the error of an unreadable policy.
        policy = load_policy(keystore.policy_path)
        findings += [Finding(each, is_error=False) for each in inexpressible(policy)]
    for each in findings:
        output.show(
            {'severity': each.severity, 'problem': each.problem},
            f'{each.severity}: {each.problem}',
            style='red' if each.is_error else 'yellow',
        )
    if not findings and not output.json:
        output.line(f'{keystore.path}: nothing is wrong')
    return Outcome.FAILED if any(each.is_error for each in findings) else Outcome.OK


def add_explain_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure explain`."""
    parser.add_argument('who', metavar='WHO', help='An identity')
    verbs = [*(verb.value for verb in Verb), STOP, MISSIONS]
    parser.add_argument('verb', metavar='VERB', choices=verbs, help=f'One of {", ".join(verbs)}')
    parser.add_argument(
        'name',
        metavar='NAME',
        nargs='?',
        help='A topic, service, action or node, like /cmd_vel; none for stop and missions',
    )
    parser.add_argument('--domain', metavar='N', type=int, default=0, help='The domain (default: 0)')
    add_keystore_argument(parser)


def explain(arguments: Namespace, output: Output) -> Outcome:
    """Print the decision of the policy; the outcome is REFUSED if the policy does not allow the act."""
    from goalwire.security.policy_file import load_policy

    policy = load_policy(find_folder(arguments) / 'policy.toml')
    if arguments.verb == STOP:
        decision = policy.decide_stop(arguments.who)
    elif arguments.verb == MISSIONS:
        decision = policy.decide_missions(arguments.who, arguments.domain)
    elif arguments.name is None:
        raise CommandError(Outcome.USAGE, f'{arguments.verb} needs a NAME', 'add one, like /cmd_vel')
    else:
        decision = policy.decide(arguments.who, Verb(arguments.verb), arguments.name, arguments.domain)
    if output.json:
        output.data({'allowed': decision.is_allowed, 'reason': decision.reason})
    else:
        answer = 'yes' if decision.is_allowed else 'no'
        output.line(f'{answer}: {decision.reason}', style='green' if decision.is_allowed else 'red')
    return Outcome.OK if decision.is_allowed else Outcome.REFUSED


def add_audit_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure audit`."""
    parser.add_argument('name', metavar='NAME', help='The identity of the program that keeps the log')
    parser.add_argument('--by', metavar='WHO', default='', help='Print only what this identity did, or tried')
    add_keystore_argument(parser)


def audit(arguments: Namespace, output: Output) -> None:
    """Print the entries. Raises SecurityError at the first line that does not follow the one before it."""
    from goalwire.security.audit import log_path, put_aside, read

    path = log_path(find_folder(arguments), arguments.name)
    aside = put_aside(path)
    if aside and min(aside) > 1:
        tell(f'entries before those in {next(iter(aside.values()))} were deleted with the oldest files')
    if not path.exists() and not aside:
        tell(f"{arguments.name} has nothing in its log: there is no '{path}'")
        return
    for entry in read(path):
        if arguments.by and entry.get('who') != arguments.by:
            continue
        if output.json:
            output.data(entry)
        else:
            output.line(_in_one_line(entry))


def _in_one_line(entry: Mapping[str, str]) -> str:
    """Return an entry as a line: time, outcome, name, act, values and reason."""
    parts = [f'{entry["time"]} {entry["outcome"]}: {entry["who"]}: {entry["act"]} {entry["key"]}']
    parts += [f'{name} {entry[name]}' for name in ('goal', 'what', 'messages', 'via') if entry.get(name)]
    return f'{", ".join(parts)}: {entry["reason"]}'
