"""launch_ros's additions to launch: nodes, their parameters and names, managed nodes, packages."""

from goalwire.launching.ros import composition, lifecycle, node, scope, substitutions

__all__ = ['composition', 'lifecycle', 'node', 'scope', 'substitutions']
