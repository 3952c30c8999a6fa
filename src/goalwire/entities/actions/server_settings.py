"""How an action server treats lost clients and its own restarts: its program or parameters decide.

Unmodified programs of rclpy cannot make these settings. So whoever starts them may, by node parameters:
`-p action_servers.move_arm.journal:=/var/lib/robot/move_arm.goals`. The parameters win over the program's own
settings, as `qos_overrides` do. Real ROS 2 ignores them, since no node declares them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.errors import RCLError
from goalwire.execution.time.steady_clock import timeout_ns
from goalwire.rules.goals.journal import read_journal
from goalwire.rules.goals.server import GoalServer

if TYPE_CHECKING:
    from pathlib import Path

    from goalwire.entities.node import NodeCore
    from goalwire.rules.goals.journal import GoalJournal
    from goalwire.rules.goals.policy import GoalPolicy, OnClientLost
    from goalwire.transport.contract import Request

PREFIX = 'action_servers'
SETTINGS = ('journal', 'on_client_lost', 'client_grace')


def make_goal_server(
    node: NodeCore,
    name: str,
    policy: GoalPolicy,
    on_client_lost: OnClientLost,
    client_grace: float,
    journal: str | Path | GoalJournal | None,
    **limits: int,
) -> GoalServer[Request, bytes]:
    """Make the reactor of an action, which the program calls `name`; parameters of the node win over the
    program.

    `limits` are further arguments of GoalServer. Raises TypeError and ValueError for wrong arguments of the
    program, RCLError for a wrong parameter.
    """
    overrides = _overrides(node, name)
    settings = {'journal': journal, 'on_client_lost': on_client_lost, 'client_grace': client_grace}
    try:
        return _make(policy, **(settings | overrides), limits=limits)
    except (TypeError, ValueError) as error:
        if not overrides:
            raise
        given = ', '.join(f'{_parameter(name, each)}:={value}' for each, value in overrides.items())
        raise RCLError(f'a parameter of the action server is wrong ({given}): {error}') from None


def _make(
    policy: GoalPolicy, *, journal: Any, on_client_lost: Any, client_grace: Any, limits: dict[str, int]
) -> GoalServer[Request, bytes]:
    return GoalServer(
        policy=policy,
        on_client_lost=on_client_lost,
        client_grace_ns=timeout_ns(client_grace, 'client_grace'),
        journal=None if journal is None else read_journal(journal),
        **limits,
    )


def _overrides(node: NodeCore, name: str) -> dict[str, object]:
    """Return an action server's settings from the node's parameters, and note that they are used."""
    given = node.parameter_overrides()
    names = {each: _parameter(name, each) for each in SETTINGS}
    found: dict[str, object] = {each: given[full] for each, full in names.items() if full in given}
    if found and (use := node.override_use) is not None:
        for each in found:
            use.declared(node.name.qualified, _parameter(name, each))
    return found


def _parameter(name: str, setting: str) -> str:
    return f'{PREFIX}.{name.removeprefix("~").strip("/").replace("/", ".")}.{setting}'
