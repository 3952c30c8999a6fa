"""A container process for components in Python: `python -m rclpy_components.component_container`."""

from __future__ import annotations

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

from rclpy_components.component_manager import ComponentManager


def main() -> None:
    """Load components on request, and spin them in one thread until the process is interrupted."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    manager = ComponentManager(executor)
    executor.add_node(manager)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        manager.destroy_components()
        manager.destroy_node()
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
