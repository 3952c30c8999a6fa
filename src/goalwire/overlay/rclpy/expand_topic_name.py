"""rclpy.expand_topic_name: from the names that users write to fully-qualified ones."""

from goalwire.errors import LocalError
from goalwire.protocol import names


class TopicExpansionError(LocalError, ValueError):
    """A topic name, node name or namespace from which no full name can be made."""


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the absolute form of `topic_name` for that node; raises TopicExpansionError (a ValueError)."""
    try:
        return names.expand_topic_name(topic_name, node_name, node_namespace)
    except names.InvalidName as error:
        kind = 'node namespace' if error.kind == 'namespace' else error.kind
        raise TopicExpansionError(f"{kind} '{error.name}' is invalid: {error.reason}") from None
