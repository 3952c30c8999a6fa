"""rclpy.topic_or_service_is_hidden: recognizes the names that tools hide by default."""

from goalwire.rules.names import is_hidden_name

HIDDEN_TOPIC_PREFIX = '_'


def topic_or_service_is_hidden(name: str) -> bool:
    """Return whether one of the name's tokens starts with `_`."""
    return is_hidden_name(name)
