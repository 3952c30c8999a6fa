"""launch_ros.utilities: helpers for programs that define new actions."""

from goalwire.launching.ros.namespaces import (
    is_namespace_absolute,
    is_root_namespace,
    make_namespace_absolute,
    prefix_namespace,
)
from goalwire.launching.ros.node_names import (
    add_node_name,
    get_node_name_count,
)
from goalwire.launching.ros.parameter_lists import (
    to_parameters_list,
)
from goalwire.launching.ros.parameters import (
    evaluate_dictionary as evaluate_parameter_dict,
)
from goalwire.launching.ros.parameters import (
    evaluate_parameters,
    normalize_parameter_dict,
    normalize_parameters,
)
from goalwire.launching.ros.remappings import (
    normalize_remap_rule,
    normalize_remap_rules,
)

__all__ = [
    'add_node_name',
    'evaluate_parameter_dict',
    'evaluate_parameters',
    'get_node_name_count',
    'is_namespace_absolute',
    'is_root_namespace',
    'make_namespace_absolute',
    'normalize_parameter_dict',
    'normalize_parameters',
    'normalize_remap_rule',
    'normalize_remap_rules',
    'prefix_namespace',
    'to_parameters_list',
]
