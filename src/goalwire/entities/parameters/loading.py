"""Parameters for other nodes, from text or a file (rclpy.parameter)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.protocol.parameters.parameter import value_message
from goalwire.protocol.parameters.plain_yaml import flat_values, typed_text, typed_value

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage


def parameter_value_from_text(text: str) -> ParameterValueMessage:
    """Return the value that YAML text stands for; what is nothing else is a string."""
    return value_message(*typed_text(text))


def parameters_from_yaml_file(
    path: str, target_nodes: list[str] | None, namespace: str, *, use_wildcard: bool
) -> dict[str, ParameterMessage]:
    """Return what a parameter file says, by `namespace` and name in one.

    Raises OSError, yaml.YAMLError with file and line, FileShapeError (a RuntimeError).
    """
    import yaml
    from rcl_interfaces.msg import Parameter as ParameterMessage

    with Path(path).open(encoding='utf-8') as file:
        content = yaml.safe_load(file)
    values = flat_values(content, target_nodes, use_wildcard=use_wildcard)
    return {
        f'{namespace}{name}': ParameterMessage(
            name=f'{namespace}{name}', value=value_message(*typed_value(name, value))
        )
        for name, value in values.items()
    }
