"""ros2 doctor: checks this machine's setup, and advises on the faults."""

from __future__ import annotations

import os
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from time import perf_counter
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.commands.doctor.check import Check
from goalwire.apps.cli.commands.doctor.installation import check_goalwire, check_rclpy
from goalwire.apps.cli.commands.version import versions
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb
from goalwire.errors import CallError, GoalwireError, TransportError
from goalwire.rules.domain import domain_from_environment
from goalwire.security import is_asked_for
from goalwire.transport import dds, registry

if TYPE_CHECKING:
    from goalwire.aio.graph import GraphProblem
    from goalwire.apps.cli.framework.output import Output

_ENVIRONMENT = ('ROS_DOMAIN_ID', 'RMW_IMPLEMENTATION', 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'AMENT_PREFIX_PATH')
_SELF_TEST_S = 15.0
_LOOK_S = 1.0
"""Seconds that DDS participants have to answer an announcement."""


def _versions() -> Check:
    found = ', '.join(f'{name} {version}' for name, version in versions().items() if version)
    return Check('versions', True, found)


def _environment() -> Check:
    given = [f'{name}={os.environ[name]}' for name in _ENVIRONMENT if os.environ.get(name)]
    return Check('environment', True, ', '.join(given) or 'nothing of ROS 2 is set')


def _wires() -> list[Check]:
    selected = registry.select_identifier()
    checks = []
    for identifier in sorted(registry.available()):
        mark = ' (selected)' if identifier == selected else ''
        try:
            registry.get(identifier)
            if identifier in dds.IDENTIFIERS and dds.choose_session() == dds.CYCLONE:
                from goalwire.transport.dds.cyclone.library import find_library

                find_library()
        except (TransportError, ImportError) as error:
            found = f'cannot be used{mark}' if mark else 'cannot be used here, and is not selected'
            checks.append(Check(f'wire {identifier}', not mark, found, str(error), bool(mark)))
        else:
            checks.append(Check(f'wire {identifier}', True, f'can be used{mark}'))
    if selected not in registry.available():
        checks.append(
            Check(f'wire {selected}', False, 'unknown', 'set RMW_IMPLEMENTATION to one of those above')
        )
    return checks


def _port() -> Check | None:
    """Describe the program at the port of Zenoh's routers; None on another wire."""
    if registry.select_identifier() != 'rmw_zenoh_cpp':
        return None
    from goalwire.transport.zenoh.rendezvous import Holder, look, name_of_holder
    from goalwire.transport.zenoh.settings.environment import router_port

    port = router_port()
    found = look(port)
    name = f'port {port}'
    if found is Holder.ZENOH:
        return Check(name, True, f'a Zenoh router answers: {name_of_holder(port)}')
    if found is Holder.NOBODY:
        offered = 'the first program offers the rendezvous'
        here = f'doctor does so itself while it looks (process {os.getpid()})'
        return Check(name, True, f'free: {offered}; {here}')
    if found is Holder.TLS and is_asked_for():
        return Check(name, True, f'a Zenoh router with TLS answers: {name_of_holder(port)}')
    first = (
        'export GOALWIRE_SECURITY=KEYSTORE:NAME, if that is a program of yours'
        if found is Holder.TLS
        else f'end {name_of_holder(port)}'
    )
    advice = f'{first}, or set GOALWIRE_ROUTER_PORT to a free port for all programs'
    return Check(name, False, f'{name_of_holder(port)} {found.value}', advice)


def _dds() -> Check | None:
    """Describe the DDS participants and how to reach them; None if there are none and DDS is not selected."""
    from goalwire.transport.dds.vendors import look_for_participants, rmw_for, vendor_name

    selected = registry.select_identifier()
    is_selected = selected in dds.IDENTIFIERS
    if is_asked_for():
        return None  # A secured session does not answer announcements on unsecured DDS.
    name = 'DDS'
    try:
        domain = domain_from_environment()
        name = f'DDS, domain {domain}'
        found = look_for_participants(domain, _LOOK_S)
    except (TransportError, ValueError) as error:
        return Check(name, not is_selected, 'cannot be looked at', str(error), is_selected)
    if not found:
        return Check(name, True, 'nobody announces itself') if is_selected else None
    told = ', '.join(f'{count} of {vendor_name(vendor)}' for vendor, count in found.most_common())
    told = f'participants: {told}'
    if is_selected:
        return Check(name, True, told)
    vendor = found.most_common(1)[0][0]
    advice = f'{selected} does not reach them: RMW_IMPLEMENTATION={rmw_for(vendor)} does'
    return Check(name, True, told, advice, is_needed=False)


def _zenoh() -> Check | None:
    """On DDS: warn of a Zenoh router, because programs on Zenoh cannot be seen from DDS."""
    if registry.select_identifier() not in dds.IDENTIFIERS:
        return None
    from goalwire.transport.zenoh.rendezvous import Holder, look
    from goalwire.transport.zenoh.settings.environment import router_port

    port = router_port()
    if look(port) is not Holder.ZENOH:
        return None
    advice = 'its programs are not reached on DDS: RMW_IMPLEMENTATION=rmw_zenoh_cpp reaches them'
    return Check(f'Zenoh, port {port}', True, 'a router answers', advice, is_needed=False)


def _graph(arguments: Namespace) -> list[Check]:
    """Count the peers, and report their endpoints whose types or QoS do not go together."""
    from goalwire.aio.graph import find_problems

    try:
        with discovered(arguments) as graph:
            nodes, problems = graph.nodes(), list(find_problems(graph.endpoints()))
    except TransportError as error:
        return [Check('peers', False, 'no session could be opened', str(error))]
    sessions = len({node.session for node in nodes})
    names = ', '.join(sorted({node.node.qualified for node in nodes})[:10])
    told = f'{len(nodes)} nodes in {sessions} sessions{f": {names}" if names else ""}'
    return [Check('peers', True, told), *(_check_of(problem) for problem in problems)]


def _check_of(problem: GraphProblem) -> Check:
    found, _, advice = problem.text.rpartition('; ')
    return Check(problem.name, False, found or advice, advice if found else '')


def _self_test() -> Check:
    """Call a service that another process of this machine serves."""
    name = f'_goalwire_doctor_{os.getpid()}'
    command = [sys.executable, '-m', 'goalwire.apps.cli.commands.doctor.server', name]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL) as server:  # noqa: S603
        took: list[float] = []

        async def call(node: goalwire.Node) -> None:
            from std_srvs.srv import Trigger

            client = node.client(Trigger, name, timeout=_SELF_TEST_S)
            await client.call()
            began = perf_counter()
            await client.call()
            took.append(perf_counter() - began)

        try:
            outcome = live(call)
        except (CallError, GoalwireError) as error:
            return Check('self-test', False, f'two processes do not reach each other: {error}', _advice())
        finally:
            server.kill()
    if outcome is not Outcome.OK:
        raise KeyboardInterrupt
    return Check('self-test', True, f'another process answered a service call within {took[0] * 1000:.2f} ms')


def _advice() -> str:
    if registry.select_identifier() == 'rmw_zenoh_cpp':
        return 'see the port above, and GOALWIRE_ROUTER: someone must offer the rendezvous'
    return 'see ROS_AUTOMATIC_DISCOVERY_RANGE and the firewall: discovery uses UDP multicast'


def _arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        '-r', '--report', action='store_true', help='Accepted as in ROS 2: the full report is always printed'
    )
    parser.add_argument('-rf', '--report-failed', action='store_true', help='Print only the failed checks')
    parser.add_argument('--no-self-test', action='store_true', help='Start no second process')


def _doctor(arguments: Namespace, output: Output) -> Outcome:
    from collections.abc import Callable, Iterable

    looks: list[Callable[[], Check | Iterable[Check] | None]] = [
        _versions,
        check_goalwire,
        check_rclpy,
        _environment,
        _wires,
        _port,
        _dds,
        _zenoh,
        lambda: _graph(arguments),
    ]
    if not arguments.no_self_test:
        looks.append(_self_test)
    failed: list[Check] = []
    for look in looks:
        found = look()
        checks = [found] if isinstance(found, Check) else list(found or ())
        for check in checks:
            if not check.is_well:
                failed.append(check)
            if check.is_well and arguments.report_failed:
                continue
            _show(check, output)
    if failed:
        names = ', '.join(check.name for check in failed)
        raise CommandError(Outcome.FAILED, f'not well: {names}', f'next: {failed[0].advice}')
    if not output.json:
        output.line('all is well', style='green')
    return Outcome.OK


def _show(check: Check, output: Output) -> None:
    if output.json:
        output.data(check._asdict())
        return
    mark = ('ok  ' if check.is_needed else '-   ') if check.is_well else 'FAIL'
    output.line(f'{mark} {check.name}: {check.found}', style='' if check.is_well else 'red')
    if check.advice:
        output.line(f'     {check.advice}', style='dim')
    output.flush()


NOUN = Noun(
    'doctor',
    'Check what works here, and say what to do next',
    (Verb('doctor', 'Check what works here, and say what to do next', _doctor, _arguments),),
)
