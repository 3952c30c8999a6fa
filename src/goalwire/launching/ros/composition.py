"""Starts containers of components, and loads components into them.

A container of C++ components is a program of ROS 2. Without a sourced ROS 2 it is missing: its C++ components
are skipped with one warning, and its Python components run in the container of `rclpy_components`.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Iterable
from typing import Any

from goalwire.errors import CallError, LaunchError, NoServerError
from goalwire.launching.actions import OpaqueFunction
from goalwire.launching.errors import as_sentence
from goalwire.launching.event_handlers import OnShutdown
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import Action, LaunchContext, LaunchDescriptionEntity, SomeSubstitutions
from goalwire.launching.output import get_logger
from goalwire.launching.packages import has_component
from goalwire.launching.ros.components import ComposableNode, parse_components
from goalwire.launching.ros.load_requests import get_composable_node_load_request
from goalwire.launching.ros.missing_containers import CPP_ADVICE, missing_container, note_missing_container
from goalwire.launching.ros.node import Node, warn_of_twins
from goalwire.launching.ros.node_names import add_node_name
from goalwire.launching.ros.own_node import LaunchNode
from goalwire.launching.values import describe_text, normalize_to_list_of_substitutions, perform_text

PATIENCE_S = 5.0
"""The seconds after which the launch warns that a container does not answer."""
PYTHON_CONTAINER = [sys.executable, '-m', 'rclpy_components.component_container']


@expose_action('node_container')
class ComposableNodeContainer(Node):
    """Runs a process that loads composable nodes."""

    def __init__(
        self,
        *,
        name: SomeSubstitutions,
        namespace: SomeSubstitutions,
        composable_node_descriptions: Iterable[ComposableNode] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **options)
        self.composable_node_descriptions = list(composable_node_descriptions or ())

    @classmethod
    def parse(
        cls, entity: Entity, parser: Parser, ignore: Iterable[str] = ()
    ) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser, ignore)
        for needed in ('name', 'namespace'):
            if needed not in arguments:
                raise LaunchError(f"<node_container> needs the attribute '{needed}'")
        components = parse_components(entity.get_entities('composable_node'), parser)
        return cls, arguments | {'composable_node_descriptions': components}

    def may_lack_program(self, context: LaunchContext) -> bool:
        return True

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        if context.is_shutdown:
            return None
        try:
            self.process_description.command(context)
        except LaunchError as error:
            self.expand_names(context)
            note_missing_container(context, self.node_name, self)
            return self._load_python(context, error)
        self.start(context)
        return loading(self.composable_node_descriptions, self)

    def _load_python(self, context: LaunchContext, error: LaunchError) -> list[LaunchDescriptionEntity]:
        """Warn which C++ components are skipped, and return the action that loads the Python components."""
        python, others = divide(context, self.composable_node_descriptions)
        if others or not python:
            which = ', '.join(_plugin(context, item) for item in others)
            get_logger('launch_ros').warning(
                f'container {self.node_name}: skipped{" " + which if which else ""} '
                f'({as_sentence(error)}). {CPP_ADVICE}'
            )
        if python:
            stand_in(context, self)
        return loading(python, self)


def divide(
    context: LaunchContext, components: Iterable[ComposableNode]
) -> tuple[list[ComposableNode], list[ComposableNode]]:
    """Return Python components and C++ components, both without components whose condition is false."""
    wanted = [item for item in components if (held := item.condition()) is None or held.evaluate(context)]
    python = [item for item in wanted if _is_python(context, item)]
    return python, [item for item in wanted if item not in python]


def stand_in(context: LaunchContext, container: Node) -> None:
    """In place of a skipped container, start goalwire's container for Python components, once."""
    if container.process_details is None:
        container.start(context, PYTHON_CONTAINER)


def loading(components: list[ComposableNode], container: Node) -> list[LaunchDescriptionEntity]:
    """Return the action that loads components, as a list; [] if there are no components."""
    if not components:
        return []
    return [LoadComposableNodes(composable_node_descriptions=components, target_container=container)]


def _plugin(context: LaunchContext, component: ComposableNode) -> str:
    return perform_text(context, component.node_plugin)


def _is_python(context: LaunchContext, component: ComposableNode) -> bool:
    return has_component(perform_text(context, component.package), _plugin(context, component))


@expose_action('load_composable_node')
class LoadComposableNodes(Action):
    """Loads composable nodes into a running container, one after the other."""

    def __init__(
        self,
        *,
        composable_node_descriptions: Iterable[ComposableNode],
        target_container: SomeSubstitutions | Node,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self.composable_node_descriptions = list(composable_node_descriptions)
        self._target = (
            target_container
            if isinstance(target_container, Node)
            else normalize_to_list_of_substitutions(target_container)
        )
        self._task: asyncio.Task[None] | None = None

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        arguments['target_container'] = parser.parse_substitution(entity.get_attr('target'))
        components = entity.get_entities('composable_node')
        arguments['composable_node_descriptions'] = parse_components(components, parser)
        return cls, arguments

    def describe(self) -> str:
        target = self._target
        name = target.describe() if isinstance(target, Node) else describe_text(target)
        return f'{type(self).__name__}({", ".join([name, *_describe(self.composable_node_descriptions)])})'

    def get_asyncio_future(self) -> asyncio.Future[None] | None:
        return self._task

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        if context.is_shutdown:
            return None
        container = self._container(context)
        components = self._loadable(context, missing_container(context, container))
        requests = [
            request
            for component in components
            if (request := get_composable_node_load_request(component, context)) is not None
        ]
        if not requests:
            return None
        self._task = task = LaunchNode.of(context).start(_load(context, container, requests))

        def abandon(_: LaunchContext) -> None:
            if task.cancel():
                get_logger('launch_ros').warning(
                    f"Abandoning the '{container}/_container/load_node' service, due to shutdown."
                )

        abandons = OpaqueFunction(function=abandon)
        context.register_event_handler(OnShutdown(on_shutdown=abandons, handle_once=True))
        return None

    def _loadable(self, context: LaunchContext, skipped: Node | None) -> list[ComposableNode]:
        """Return the components to load: only Python components if the C++ container was skipped."""
        if skipped is None or self._target is skipped:
            return self.composable_node_descriptions
        python, others = divide(context, self.composable_node_descriptions)
        for item in others:
            get_logger('launch_ros').info(
                f'{_plugin(context, item)} is skipped with its container {skipped.node_name}'
            )
        if python:
            stand_in(context, skipped)
        return python

    def _container(self, context: LaunchContext) -> str:
        if isinstance(self._target, Node):
            return self._target.node_name
        name = perform_text(context, self._target)
        return name if name.startswith('/') else f'/{name}'


def _describe(components: Iterable[ComposableNode]) -> list[str]:
    return [component.describe() for component in components]


async def _load(context: LaunchContext, container: str, requests: list[Any]) -> None:
    """Wait for a container, and ask it to load components in order.

    If the container refuses a component, the others are still loaded.
    """
    from composition_interfaces.srv import LoadNode

    logger = get_logger('launch_ros')
    client = await LaunchNode.of(context).client(LoadNode, f'{container}/_container/load_node')
    try:
        await client.wait_for_server(timeout=PATIENCE_S)
    except NoServerError:
        logger.warning(f"container '{container}' does not answer: its components wait for it")
    for request in requests:
        what = f"node '{request.node_name}' of type '{request.plugin_name}' in container '{container}'"
        try:
            await client.wait_for_server()
            response = await client.call(request)
        except CallError as error:
            logger.error(f'Failed to load {what}: {error}')
            continue
        if not response.success:
            logger.error(f'Failed to load {what}: {response.error_message}')
            continue
        name = response.full_node_name or request.node_name
        if name:
            add_node_name(context, name)
            warn_of_twins(context, name, 'launch_ros')
        logger.info(f"Loaded node '{name}' in container '{container}'")
