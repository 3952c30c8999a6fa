"""rclpy.qos_event: the old name of rclpy.event_handler."""

import warnings

from rclpy.event_handler import *  # noqa: F403

warnings.warn("importing 'qos_event' is deprecated; import 'event_handler' instead", stacklevel=2)
