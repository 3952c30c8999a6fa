"""The node of a component container: its services load, unload and list components."""

from __future__ import annotations

import inspect
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from composition_interfaces.srv import ListNodes, LoadNode, UnloadNode
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from goalwire.launching.packages import COMPONENTS, source_components
from goalwire.launching.source_modules import offer_source_modules


class ComponentManager(Node):
    """Loads components into the executor that spins this node. It has the services of ROS 2's containers."""

    def __init__(self, executor: Executor, name: str = 'py_component_manager', **options: Any) -> None:
        super().__init__(name, **options)
        self._loads_into = executor
        self._components: dict[int, Node] = {}
        self._last_id = 0
        self._container_services = [
            self.create_service(LoadNode, '~/_container/load_node', self._load),
            self.create_service(UnloadNode, '~/_container/unload_node', self._unload),
            self.create_service(ListNodes, '~/_container/list_nodes', self._list),
        ]

    def _load(self, request: LoadNode.Request, response: LoadNode.Response) -> LoadNode.Response:
        try:
            made = component_class(request.package_name, request.plugin_name)
            node = made(**_options(request, self))
        except Exception as error:
            response.success = False
            notes = ''.join(f'; {note}' for note in getattr(error, '__notes__', ()))
            response.error_message = f'{type(error).__name__}: {error}{notes}'
            self.get_logger().error(f"Failed to load '{request.plugin_name}': {response.error_message}")
            return response
        if request.log_level:
            node.get_logger().set_level(request.log_level)
        self._last_id += 1
        self._components[self._last_id] = node
        self._loads_into.add_node(node)
        response.success = True
        response.unique_id = self._last_id
        response.full_node_name = node.get_fully_qualified_name()
        return response

    def _unload(self, request: UnloadNode.Request, response: UnloadNode.Response) -> UnloadNode.Response:
        node = self._components.pop(request.unique_id, None)
        response.success = node is not None
        if node is None:
            response.error_message = f'there is no component {request.unique_id}; list_nodes gives their ids'
        else:
            self._loads_into.remove_node(node)
            node.destroy_node()
        return response

    def _list(self, _: ListNodes.Request, response: ListNodes.Response) -> ListNodes.Response:
        response.unique_ids = list(self._components)
        response.full_node_names = [node.get_fully_qualified_name() for node in self._components.values()]
        return response

    def destroy_components(self) -> None:
        """Destroy the loaded components, the last one first."""
        while self._components:
            _, node = self._components.popitem()
            node.destroy_node()


def component_class(package: str, plugin: str) -> type[Node]:
    """Return a component's class.

    Raises LookupError for an unknown component, TypeError for a non-Node class.
    """
    for point in [*entry_points(group=COMPONENTS), *source_components(package)]:
        if point.name == plugin:
            return _loaded(point)
    raise LookupError(
        f"there is no component '{plugin}' of the package '{package}' in Python: its setup.py names "
        f"components in the group '{COMPONENTS}' of its entry points"
    )


def _loaded(point: EntryPoint) -> type[Node]:
    offer_source_modules()
    found = point.load()
    if not (inspect.isclass(found) and issubclass(found, Node)):
        raise TypeError(f"the component '{point.name}' ({point.value}) is not derived from rclpy.node.Node")
    return found


def _options(request: LoadNode.Request, manager: Node) -> dict[str, Any]:
    """Return the arguments that a component passes on to Node's constructor."""
    rules = list(request.remap_rules)
    if request.node_name:
        rules.append(f'__node:={request.node_name}')
    if request.node_namespace:
        rules.append(f'__ns:={request.node_namespace}')
    arguments = [word for rule in rules for word in ('-r', rule)]
    return {
        'context': manager.context,
        'use_global_arguments': False,
        'cli_args': ['--ros-args', *arguments],
        'parameter_overrides': [Parameter.from_parameter_msg(item) for item in request.parameters],
    }
