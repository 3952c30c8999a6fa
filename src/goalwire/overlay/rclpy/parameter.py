"""rclpy.parameter: the class Parameter, and functions that read values from messages, text and files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.rules.parameters import SEPARATOR, Parameter, ParameterValue
from goalwire.rules.parameters.messages import value_of
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage

PARAMETER_SEPARATOR_STRING = SEPARATOR

__all__ = [
    'PARAMETER_SEPARATOR_STRING',
    'Parameter',
    'get_parameter_value',
    'parameter_dict_from_yaml_file',
    'parameter_value_to_python',
]


def parameter_value_to_python(parameter_value: ParameterValueMessage) -> ParameterValue:
    """Return the Python value of a ParameterValue message; raises RuntimeError for an unknown type."""
    return value_of(parameter_value)


def get_parameter_value(string_value: str) -> ParameterValueMessage:
    """Return the parameter value in a YAML text; a text that has no other type is a string."""
    from goalwire.entities.parameters.files import parameter_value_from_text

    return parameter_value_from_text(string_value)


def parameter_dict_from_yaml_file(
    parameter_file: str,
    use_wildcard: bool = False,
    target_nodes: list[str] | None = None,
    namespace: str = '',
) -> dict[str, ParameterMessage]:
    """Return a file's parameters, by name, for `target_nodes` (None: for all nodes that it names).

    The parameters of names with a `*` are included only with `use_wildcard`. Raises OSError, yaml.YAMLError,
    RuntimeError.
    """
    from goalwire.entities.parameters.files import parameters_from_yaml_file

    return parameters_from_yaml_file(parameter_file, target_nodes, namespace, use_wildcard=use_wildcard)


reexport(__name__)
