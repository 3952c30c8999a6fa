"""launch_ros: extends launch files by nodes of ROS 2."""

from launch_ros import actions, descriptions, event_handlers, events, parameter_descriptions, substitutions

__all__ = ['actions', 'descriptions', 'event_handlers', 'events', 'parameter_descriptions', 'substitutions']
