"""parameter_blackboard: a node that accepts any parameter."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node

from goalwire.apps.programs.running import spin


class ParameterBlackboard(Node):
    """A node on which undeclared parameters may be set; it declares all overrides."""

    def __init__(self) -> None:
        super().__init__(
            'parameter_blackboard',
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        self.get_logger().info(
            f"Parameter blackboard node named '{self.get_fully_qualified_name()}' ready, and serving "
            f"'{len(self.get_parameters_by_prefix(''))}' parameters already!"
        )


def main(args: Sequence[str] | None = None) -> int:
    """Run parameter_blackboard."""
    return spin(ParameterBlackboard, args)
