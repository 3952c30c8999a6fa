"""rclpy.impl.implementation_singleton: rclpy's C extension, under the name by which programs know it."""

from rclpy import _rclpy_pybind11 as rclpy_implementation

__all__ = ['package', 'rclpy_implementation']

package = 'rclpy'
