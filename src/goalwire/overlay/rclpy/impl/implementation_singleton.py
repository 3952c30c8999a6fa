"""rclpy.impl.implementation_singleton: the stand-in for rclpy's C extension, where programs import it."""

from rclpy import _rclpy_pybind11 as rclpy_implementation

__all__ = ['package', 'rclpy_implementation']

package = 'rclpy'
