"""launch_ros: nodes in launch files."""

from launch_ros import actions, descriptions, event_handlers, events, parameter_descriptions, substitutions

__all__ = ['actions', 'descriptions', 'event_handlers', 'events', 'parameter_descriptions', 'substitutions']
