"""Parameters for other nodes, from text or a file (rclpy.parameter)."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

from goalwire.errors import FileShapeError
from goalwire.files import LARGEST_PARAMETER_FILE, read_regular
from goalwire.rules.parameters.parameter import value_message
from goalwire.rules.parameters.plain_yaml import flat_values, typed_text, typed_value

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

    Raises OSError (also for what is no regular file, or too large), yaml.YAMLError with file and line,
    FileShapeError (a RuntimeError).
    """
    import yaml
    from rcl_interfaces.msg import Parameter as ParameterMessage

    content = BytesIO(read_regular(path, LARGEST_PARAMETER_FILE))
    content.name = path  # YAML's errors tell it
    try:
        tree = yaml.safe_load(content)
    except yaml.YAMLError:
        raise
    except Exception as error:  # PyYAML raises anything
        raise FileShapeError(f'{path}: a value cannot be read: {error}') from None
    values = flat_values(tree, target_nodes, use_wildcard=use_wildcard)
    return {
        f'{namespace}{name}': ParameterMessage(
            name=f'{namespace}{name}', value=value_message(*typed_value(name, value))
        )
        for name, value in values.items()
    }
