"""Expands and checks names by the rules of ROS 2 (goalwire.rules.names), with rclpy's exceptions."""

from __future__ import annotations

from typing import NamedTuple

from goalwire.errors import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    RCLError,
    TopicExpansionError,
)
from goalwire.rules import names
from goalwire.rules.names import ActionNames, InvalidName, RemapRules, UnknownSubstitution
from goalwire.transport.contract import NodeName

_EXCEPTIONS = {
    'node name': InvalidNodeNameException,
    'namespace': InvalidNamespaceException,
    'topic name': InvalidTopicNameException,
    'service name': InvalidServiceNameException,
}


class rclpy_exceptions:  # noqa: N801 - used as a function is
    """Turn InvalidName into the exception that rclpy's programs catch.

    A class, since a generator would take four times as long, and each name of each endpoint passes here
    twice.
    """

    __slots__ = ()

    def __enter__(self) -> None:
        """Watch the block."""

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Raise rclpy's exception in the place of InvalidName."""
        if isinstance(error, UnknownSubstitution):
            raise TopicExpansionError('topic name', error.name, error.reason) from None
        if isinstance(error, InvalidName):
            raise _EXCEPTIONS[error.kind](error.name, error.reason, error.index) from None


def node_names(name: str, namespace: str | None, remaps: RemapRules, enclave: str) -> NodeName:
    """Return a node's remapped names; raises InvalidNodeNameException or InvalidNamespaceException."""
    check_is_name(name, 'error creating node: name argument is null')
    with rclpy_exceptions():
        names.validate_node_name(name)
        absolute = names.absolute_namespace(namespace or '/')
        names.validate_namespace(absolute)
        remapped = remaps.node_name(name)
        names.validate_node_name(remapped)
        absolute = remaps.namespace(absolute, remapped)
        names.validate_namespace(absolute)
    return NodeName(remapped, absolute, enclave)


def expand_name(name: str, node: NodeName, *, is_service: bool) -> str:
    """Return the fully-qualified form of a topic or service name of `node`, not remapped.

    Raises InvalidTopicNameException or InvalidServiceNameException, TopicExpansionError (a ValueError) for an
    unknown substitution.
    """
    check_is_name(name, None if is_service else 'failed to validate name: topic_name argument is null')
    with rclpy_exceptions():
        return names.qualify_topic_name(name, node.name, node.namespace, is_service=is_service)


def remap_name(full_name: str, node: NodeName, remaps: RemapRules, *, is_service: bool) -> str:
    """Return a fully-qualified name as the remap rules change it."""
    remap = remaps.service if is_service else remaps.topic
    with rclpy_exceptions():
        renamed = remap(full_name, node.name, node.namespace)
        names.validate_full_topic_name(renamed, is_service=is_service)
    return renamed


class ResolvedAction(NamedTuple):
    """The fully-qualified, remapped names of an action and its five parts."""

    name: str
    send_goal: str
    cancel_goal: str
    get_result: str
    feedback: str
    status: str


def resolve_action_names(name: str, node: NodeName, remaps: RemapRules) -> ResolvedAction:
    """Expand and remap an action's name, as ROS 2 does from Kilted on; then remap the names of its parts.

    Raises InvalidTopicNameException.
    """
    full = expand_name(name, node, is_service=False)
    parts = ActionNames(remap_name(full, node, remaps, is_service=False))
    send_goal, cancel_goal, get_result = (
        remap_name(part, node, remaps, is_service=True)
        for part in (parts.send_goal, parts.cancel_goal, parts.get_result)
    )
    feedback, status = (
        remap_name(part, node, remaps, is_service=False) for part in (parts.feedback, parts.status)
    )
    served = send_goal.removesuffix(ActionNames('').send_goal)
    return ResolvedAction(served, send_goal, cancel_goal, get_result, feedback, status)


def check_is_name(name: object, complaint_of_none: str | None = None) -> None:
    """Raise TypeError for anything but a string. For None raise RCLError, as ROS 2's C library does."""
    if name is None and complaint_of_none:
        raise RCLError(complaint_of_none)
    if not isinstance(name, str):
        raise TypeError(f'a name is a str, not {type(name).__name__}: {name!r}')
