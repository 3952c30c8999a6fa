"""rclpy.parameter: a name, a type and a value."""

from goalwire.protocol.parameters import Parameter

PARAMETER_SEPARATOR_STRING = '.'

__all__ = ['PARAMETER_SEPARATOR_STRING', 'Parameter']
