"""rclpy_components: containers, which load nodes written in Python, found by their entry points.

A component is a class derived from rclpy's Node. Its package names it in the group `rclpy_components` of its
entry points, as in `my_robot::Camera = my_robot.camera:Camera`.
"""

from rclpy_components.component_manager import ComponentManager

__all__ = ['ComponentManager']
