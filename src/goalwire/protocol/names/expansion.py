"""From the names users write to fully qualified ones (rcl_expand_topic_name), and what a node is called."""

from __future__ import annotations

import re
from dataclasses import dataclass

from goalwire.protocol.names.validation import (
    InvalidName,
    validate_full_topic_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)

_SUBSTITUTION = re.compile(r'\{([^{}]*)\}')


@dataclass(frozen=True, slots=True)
class NodeName:
    """A node's name and its absolute namespace."""

    name: str
    namespace: str = '/'

    @property
    def full(self) -> str:
        """The fully qualified name, `/ns/name`."""
        return join(self.namespace, self.name)


def join(namespace: str, name: str) -> str:
    """Put `name` below an absolute namespace."""
    return namespace + name if namespace.endswith('/') else f'{namespace}/{name}'


def absolute_namespace(namespace: str) -> str:
    """Return what a node makes of the namespace it was given: a missing `/` is put in front."""
    return namespace if namespace.startswith('/') else f'/{namespace}'


def expand_topic_name(name: str, node: NodeName, *, is_service: bool = False) -> str:
    """Return the absolute form of `name` as `node` means it.

    Raises InvalidName for a name, node name or namespace that ROS 2 forbids, and for an unknown substitution. The
    result may still break the rules of full names, as `a//b` does: `qualify_topic_name` looks at these too.
    """
    validate_topic_name(name, is_service=is_service)
    validate_node_name(node.name)
    validate_namespace(node.namespace)
    kind = 'service name' if is_service else 'topic name'
    values = {'node': node.name, 'ns': node.namespace, 'namespace': node.namespace}

    def value(found: re.Match[str]) -> str:
        if found[1] not in values:
            raise InvalidName(kind, name, f'unknown substitution: {found[0]}', found.start())
        return values[found[1]]

    expanded = node.full + name[1:] if name.startswith('~') else name
    expanded = _SUBSTITUTION.sub(value, expanded)
    return expanded if expanded.startswith('/') else join(node.namespace, expanded)


def qualify_topic_name(name: str, node: NodeName, *, is_service: bool = False) -> str:
    """Expand `name` and hold the result against the rules of full names; raises InvalidName."""
    full = expand_topic_name(name, node, is_service=is_service)
    validate_full_topic_name(full, is_service=is_service)
    return full
