"""goalwire secure explain: says if an identity may do something, and which line of the policy decides."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, find_folder
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.security.policy import MISSIONS, STOP, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
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


def run(arguments: Namespace, output: Output) -> Outcome:
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
