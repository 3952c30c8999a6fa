"""Fetches the definition of an unknown type from a node that uses the type (REP 2016).

Every node of ROS 2 since Jazzy offers `~/get_type_description`. A description is accepted only if its hash is
the hash that the node's endpoint announces on the wire: so a wrong description is never used to read a
message.
"""

from __future__ import annotations

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.errors import GoalwireError, InterfaceError, UnknownInterfaceError, peer_text
from goalwire.idl import type_hash
from goalwire.idl.descriptions import register_descriptions
from goalwire.logging import get_logger
from goalwire.observe.messages import interface_class

if TYPE_CHECKING:
    from type_description_interfaces.msg import TypeDescription

    from goalwire.transport.contract import GraphEntity

SEARCH_S = 2.0
"""The time in s for which nodes are looked for that use the type and offer `get_type_description`."""
ANSWER_S = 3.0
"""The time in s that a node may take to describe a type."""


async def class_in_use(node: goalwire.Node, name: str) -> Any:
    """Return the class of 'pkg/kind/Name'. If it is unknown here, nodes that use it are asked.

    Raises UnknownInterfaceError.
    """
    try:
        return interface_class(name)
    except UnknownInterfaceError:
        if not await fetch_type(node, name):
            raise
    return interface_class(name)


def whole_type(name: str) -> str:
    """Return the type that a type is part of: for a service's events the service, for an action's services
    the action.

    A name that is not 'pkg/kind/Name' is returned unchanged: programs without ROS 2 announce such types.
    """
    package, *rest = name.split('/')
    if len(rest) != 2 or rest[0] == 'msg':
        return name
    kind, part = rest
    return f'{package}/{kind}/{part.partition("_")[0]}'


async def fetch_type(node: goalwire.Node, name: str) -> bool:
    """Make 'pkg/kind/Name' known by asking nodes that use it; return whether that worked.

    The name may be the name of a part of a service or action. If a node's answer is missing or wrong, the
    next node is asked.
    """
    if await _fetch(node, whole_type(name)):
        return True
    # DDS announces no hash of a service, but the hash of its event type, which contains all parts of the
    # service.
    return '/srv/' in name and name.endswith('_Event') and await _fetch(node, name)


async def _fetch(node: goalwire.Node, name: str) -> bool:
    """Fetch the definition of a message, a service, an action, or the event type of a service.

    An action's definition is composed of the descriptions of its parts.
    """
    endpoints = await _endpoints_of(node, name)
    descriptions = [await _describe(node, parts) for parts in endpoints.values()]
    found = [description for description in descriptions if description is not None]
    if not found or len(found) < len(descriptions):
        return False
    try:
        register_descriptions(name, found)
        wrong = [part for part, users in endpoints.items() if type_hash(part) != users[0].type_hash]
    except InterfaceError as error:
        get_logger('goalwire').warning(f'the description of {name} cannot be used: {peer_text(error, 200)}')
        return False
    return not wrong


async def _endpoints_of(node: goalwire.Node, name: str) -> dict[str, list[GraphEntity]]:
    """Return the endpoints that use a type, by the type that they announce; an action's endpoints announce
    its parts.

    Only endpoints of nodes that offer `get_type_description` are returned: older releases do not offer it.
    """
    parts = {name}
    if '/action/' in name:
        parts = {f'{name}_SendGoal', f'{name}_GetResult', f'{name}_FeedbackMessage'}
    found: dict[str, list[GraphEntity]] = {}
    changes = node.graph.changes()
    with suppress(TimeoutError):
        async with asyncio.timeout(SEARCH_S):
            while not found.keys() >= parts:
                found = {}
                for each in node.graph.endpoints():
                    if each.type_name in parts and each.type_hash and node.graph.servers(_service_of(each)):
                        found.setdefault(each.type_name, []).append(each)
                if not found.keys() >= parts:
                    await anext(changes)
    changes.close()
    return found if found.keys() >= parts else {}


def _service_of(user: GraphEntity) -> str:
    return f'{user.node.qualified}/get_type_description'


async def _describe(node: goalwire.Node, users: list[GraphEntity]) -> TypeDescription | None:
    """Return the first description of a type whose hash is the hash that the answering node's endpoint
    announces.
    """
    from type_description_interfaces.srv import GetTypeDescription

    from goalwire.cdr.type_hash import hash_of_description

    for user in users:
        client = node.client(GetTypeDescription, _service_of(user))
        try:
            response = await client.call(
                GetTypeDescription.Request(
                    type_name=user.type_name, type_hash=user.type_hash, include_type_sources=False
                ),
                timeout=ANSWER_S,
            )
        except GoalwireError:
            continue
        finally:
            client.close()
        if response.successful and hash_of_description(response.type_description) == user.type_hash:
            return response.type_description
    return None


def fetch_type_now(name: str) -> bool:
    """Call `fetch_type` with a separate node on a thread with its own loop, and return its result."""

    async def ask() -> bool:
        async with goalwire.Node(f'_goalwire_types_{os.getpid()}', program_arguments=False) as node:
            return await fetch_type(node, name)

    with ThreadPoolExecutor(1, 'goalwire-types') as pool:
        return pool.submit(asyncio.run, ask()).result()
