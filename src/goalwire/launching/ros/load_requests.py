"""Makes the requests that ask a container to load components."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from goalwire.launching.model import LaunchContext
from goalwire.launching.ros.components import ComposableNode
from goalwire.launching.ros.namespaces import join_namespace
from goalwire.launching.ros.parameter_lists import to_parameters_list
from goalwire.launching.ros.parameters import ParameterFile, evaluate_parameters, normalize_parameter_dict
from goalwire.launching.values import perform_substitutions, perform_text


def get_composable_node_load_request(
    composable_node_description: ComposableNode, context: LaunchContext
) -> Any:
    """Return the LoadNode.Request for a component, or None if its condition does not hold.

    The request includes the namespace, remappings and parameters set in the scope. Raises LaunchError.
    """
    from composition_interfaces.srv import LoadNode

    node = composable_node_description
    condition = node.condition()
    if condition is not None and not condition.evaluate(context):
        return None
    request = LoadNode.Request()
    request.package_name = perform_substitutions(context, node.package)
    request.plugin_name = perform_substitutions(context, node.node_plugin)
    if node.node_name is not None:
        request.node_name = perform_substitutions(context, node.node_name)
    own = None if node.node_namespace is None else perform_substitutions(context, node.node_namespace)
    namespace = join_namespace(context.launch_configurations.get('ros_namespace'), own)
    if namespace is not None:
        request.node_namespace = namespace or '/'
    remaps = list(context.launch_configurations.get('ros_remaps', ()))
    remaps += [(perform_text(context, src), perform_text(context, dst)) for src, dst in node.remappings or ()]
    request.remap_rules = [f'{src}:={dst}' for src, dst in remaps]
    given = [
        normalize_parameter_dict(dict([entry])) if isinstance(entry, tuple) else ParameterFile(Path(entry))
        for entry in context.launch_configurations.get('global_params', ())
    ]
    given += node.parameters or ()
    for field, items in (('parameters', given), ('extra_arguments', node.extra_arguments or ())):
        values = evaluate_parameters(context, items)
        listed = to_parameters_list(context, request.node_name, namespace, values)
        setattr(request, field, [item.to_parameter_msg() for item in listed])
    return request
