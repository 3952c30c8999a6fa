"""Remembers the C++ containers that a launch has skipped because their program is not installed."""

from __future__ import annotations

from typing import Any

from goalwire.launching.model import LaunchContext

CPP_CONTAINERS = 'rclcpp_components'
"""The package with ROS 2's container programs for C++ components."""
CPP_ADVICE = (
    'C++ components need a component container of ROS 2: launch this part with a sourced ROS 2, '
    'or run ordinary executables with Node(…)'
)
_GLOBAL = 'missing_containers'


def note_missing_container(context: LaunchContext, name: str, action: Any) -> None:
    """Remember the action of a skipped container by the container's full name."""
    context.extend_globals({_GLOBAL: {**context.get_globals().get(_GLOBAL, {}), name: action}})


def missing_container(context: LaunchContext, name: str) -> Any:
    """Return the action of a skipped container; None if no container with this name was skipped."""
    return context.get_globals().get(_GLOBAL, {}).get(name)
