"""ros2 action echo: feedback, status, and the steps of an action's calls if they are published."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.service.echo import QUEUE, name_step
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.entity_kinds import ACTIONS
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.messages import add_style_arguments, message_yaml, style_of
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.qos import add_qos_arguments, choose_qos
from goalwire.observe.messages import as_dict

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

INTERFACES = ('GOAL_SERVICE', 'CANCEL_SERVICE', 'RESULT_SERVICE', 'FEEDBACK_TOPIC', 'STATUS_TOPIC')


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action echo`."""
    ACTIONS.name_argument(parser)
    parser.add_argument('action_type', nargs='?', help='Type of the action, if the graph does not know it')
    parser.add_argument(
        '--interfaces',
        metavar='LIST',
        default=','.join(INTERFACES),
        help=f'Which parts to show, with commas between (default: all): {", ".join(INTERFACES)}. Services '
        'are shown where clients or server publish their steps',
    )
    add_style_arguments(parser)
    add_qos_arguments(parser, 'subscribe', 'reliable, with a long queue; the status, and what came before')


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print statuses and feedback until Ctrl-C."""
    wanted = [part.strip() for part in arguments.interfaces.split(',') if part.strip()]
    for part in wanted:
        if part not in INTERFACES:
            raise CommandError(
                Outcome.USAGE,
                f"--interfaces: there is no part '{part}'",
                f'the parts are: {", ".join(INTERFACES)}',
            )
    if arguments.action_type:
        name = lookup.full_name(arguments.action_name, 'action')
        type_name = lookup.type_name(arguments.action_type, 'action')
    else:
        name, type_name = ACTIONS.name_and_type(arguments)
    parts = _parts(name, type_name)

    async def follow(node: goalwire.Node) -> None:
        async with asyncio.TaskGroup() as group:
            for part in wanted:
                topic, cls, qos = parts[part]
                subscription = node.subscription(cls, topic, qos=choose_qos(arguments, qos))
                group.create_task(_follow(subscription, part, arguments, output))

    return live(follow)


def _parts(name: str, type_name: str) -> dict[str, tuple[str, Any, goalwire.QoS]]:
    """Return topic, class and QoS of each part of an action."""
    cls = lookup.interface_in_use(type_name)
    events = goalwire.QoS(depth=QUEUE)
    status = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
    parts = cls.Impl
    return {
        'GOAL_SERVICE': (f'{name}/_action/send_goal/_service_event', parts.SendGoalService.Event, events),
        'CANCEL_SERVICE': (
            f'{name}/_action/cancel_goal/_service_event',
            parts.CancelGoalService.Event,
            events,
        ),
        'RESULT_SERVICE': (f'{name}/_action/get_result/_service_event', parts.GetResultService.Event, events),
        'FEEDBACK_TOPIC': (f'{name}/_action/feedback', parts.FeedbackMessage, events),
        'STATUS_TOPIC': (f'{name}/_action/status', parts.GoalStatusMessage, status),
    }


async def _follow(
    subscription: goalwire.Subscription[Any], part: str, arguments: Namespace, output: Output
) -> None:
    from rosidl_runtime_py import message_to_csv, message_to_ordereddict

    async for message in subscription:
        if output.json:
            output.data({'interface': part, **name_step(as_dict(message))})
        elif arguments.csv:
            output.block(f'interface: {part}\n{message_to_csv(message, **style_of(arguments))}')
        else:
            fields = name_step(message_to_ordereddict(message, **style_of(arguments)))
            text = message_yaml(fields, flow_style=arguments.flow_style)
            output.block(f'interface: {part}\n{text}---')
