"""rclpy.expand_topic_name: from the names that users write to fully-qualified ones."""

from goalwire.errors import TopicExpansionError
from goalwire.rules import names
from rclpy._reexports import reexport


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the absolute form of `topic_name` for that node; raises TopicExpansionError (a ValueError)."""
    try:
        return names.expand_topic_name(topic_name, node_name, node_namespace)
    except names.InvalidName as error:
        raise TopicExpansionError(error.kind, error.name, error.reason) from None


reexport(__name__)
