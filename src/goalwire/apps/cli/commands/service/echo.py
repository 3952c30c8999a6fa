"""ros2 service echo: the steps of a service's calls, if its clients or server publish them."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import discovered
from goalwire.apps.cli.framework.entity_kinds import SERVICES
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.messages import add_style_arguments, message_yaml, style_of
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.qos import add_qos_arguments, choose_qos
from goalwire.observe.messages import as_dict
from goalwire.observe.service_calls import POSTFIX, STEPS
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

QUEUE = 1000
"""Default depth of the queue: the number of events that may wait."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `service echo`."""
    SERVICES.name_argument(parser)
    parser.add_argument('service_type', nargs='?', help='Type of the service, if the graph does not know it')
    add_style_arguments(parser)
    add_qos_arguments(parser, 'subscribe', 'reliable, with a long queue')


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print events until Ctrl-C."""
    name = lookup.full_name(arguments.service_name, 'service')
    if arguments.service_type:
        type_name = lookup.type_name(arguments.service_type, 'srv')
    else:
        name, type_name = SERVICES.name_and_type(arguments)
    _tell_if_silent(name, arguments)
    event = lookup.interface_in_use(type_name).Event

    async def follow(node: goalwire.Node) -> None:
        qos = choose_qos(arguments, goalwire.QoS(depth=QUEUE))
        async for message in node.subscription(event, name + POSTFIX, qos=qos):
            _show(message, arguments, output)

    return live(follow)


def _tell_if_silent(name: str, arguments: Namespace) -> None:
    """Print advice if nobody publishes the steps of the service's calls."""
    topic = name + POSTFIX
    with discovered(arguments, lambda graph: graph.count(EndpointKind.PUBLISHER, topic) > 0) as graph:
        if graph.count(EndpointKind.PUBLISHER, topic):
            return
    tell(
        f"nobody publishes the calls of '{name}': its server and clients have introspection off. Switch it "
        'on in the server: service.configure_introspection(node.get_clock(), qos_profile_system_default, '
        'ServiceIntrospectionState.CONTENTS), with a client likewise. Waiting; Ctrl-C ends this'
    )


def name_step(fields: Any) -> Any:
    """Replace the number of the step by its name in the fields of a service event."""
    info = fields.get('info')
    if isinstance(info, dict) and info.get('event_type') in range(len(STEPS)):
        info['event_type'] = STEPS[info['event_type']]
    return fields


def _show(message: Any, arguments: Namespace, output: Output) -> None:
    from rosidl_runtime_py import message_to_csv, message_to_ordereddict

    if arguments.csv and not output.json:
        output.block(message_to_csv(message, **style_of(arguments)))
        return
    if output.json:
        output.data(name_step(as_dict(message)))
    else:
        fields = name_step(message_to_ordereddict(message, **style_of(arguments)))
        output.block(message_yaml(fields, flow_style=arguments.flow_style) + '---')
