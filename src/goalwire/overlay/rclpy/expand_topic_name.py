"""rclpy.expand_topic_name: expands the names that users write to fully-qualified names."""

from goalwire.errors import TopicExpansionError
from goalwire.rules import names
from rclpy._reexports import reexport


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the absolute form of `topic_name` in a node; raises TopicExpansionError (a ValueError)."""
    try:
        return names.expand_topic_name(topic_name, node_name, node_namespace)
    except names.InvalidName as error:
        raise TopicExpansionError(error.kind, error.name, error.reason) from None


reexport(__name__)
