"""Expands the names that users write to fully qualified names (rcl_expand_topic_name)."""

from __future__ import annotations

import re

from goalwire.patterns import Pattern
from goalwire.rules.names.validation import (
    UnknownSubstitution,
    validate_full_topic_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)

_SUBSTITUTION = Pattern(r'\{([^{}]*)\}')


def join(namespace: str, name: str) -> str:
    """Put `name` below an absolute namespace."""
    return namespace + name if namespace.endswith('/') else f'{namespace}/{name}'


def absolute_namespace(namespace: str) -> str:
    """Return a namespace with a `/` in front, the form that nodes use."""
    return namespace if namespace.startswith('/') else f'/{namespace}'


def expand_topic_name(name: str, node_name: str, namespace: str, *, is_service: bool = False) -> str:
    """Return the absolute name that `name` stands for in the node `node_name` in `namespace`.

    Raises InvalidName for a name, node name or namespace that ROS 2 forbids, and for an unknown substitution.
    The result may still break the rules of full names, as `/a//b` does. `qualify_topic_name` checks these
    rules, too.
    """
    validate_topic_name(name, is_service=is_service)
    validate_node_name(node_name)
    validate_namespace(namespace)
    expanded = join(namespace, node_name) + name[1:] if name.startswith('~') else name
    if '{' in expanded:
        kind = 'service name' if is_service else 'topic name'
        values = {'node': node_name, 'ns': namespace, 'namespace': namespace}

        def value(found: re.Match[str]) -> str:
            if found[1] not in values:
                raise UnknownSubstitution(kind, name, f'unknown substitution: {found[0]}', found.start())
            return values[found[1]]

        expanded = _SUBSTITUTION.sub(value, expanded)
    return expanded if expanded.startswith('/') else join(namespace, expanded)


def qualify_topic_name(name: str, node_name: str, namespace: str, *, is_service: bool = False) -> str:
    """Expand `name`, and check the result by the rules of full names; raises InvalidName."""
    full = expand_topic_name(name, node_name, namespace, is_service=is_service)
    validate_full_topic_name(full, is_service=is_service)
    return full
