"""The verbs of the policy that an act needs: the use of a name in the graph, or an offer under a name.

The topics and services of an action belong to the action, and those of parameters to the node.
"""

from __future__ import annotations

from typing import NamedTuple

from goalwire.security.policy import Verb

_PART = '/_action/'
READING = ('get_parameters', 'get_parameter_types', 'list_parameters', 'describe_parameters')
"""The services that read a node's parameters."""
SETTING = ('set_parameters', 'set_parameters_atomically')
"""The services that set them."""
_OF_ACTIONS = {
    'send_goal': (Verb.SEND,),
    'cancel_goal': (Verb.CANCEL,),
    'get_result': (Verb.SEND, Verb.WATCH),
    'feedback': (Verb.SEND, Verb.WATCH),
    'status': (Verb.SEND, Verb.WATCH),
}


class Permission(NamedTuple):
    """The permission that an act needs: one of the verbs, on a name."""

    verbs: tuple[Verb, ...]
    name: str


def split_action(name: str) -> tuple[str, str]:
    """Split the name of an action's topic or service into the action and its part; '' and '' for others."""
    action, found, part = name.rpartition(_PART)
    return (action, part) if found and part in _OF_ACTIONS else ('', '')


def permission_to_offer(name: str, *, is_service: bool) -> Permission:
    """Return what is needed to publish on a topic, or to serve a service."""
    action, _ = split_action(name)
    if action:
        return Permission((Verb.SERVE,), action)
    return Permission((Verb.SERVE if is_service else Verb.PUBLISH,), name)


def permission_to_use(name: str, *, is_service: bool) -> Permission:
    """Return what is needed to subscribe to a topic, or to call a service."""
    action, part = split_action(name)
    if action:
        return Permission(_OF_ACTIONS[part], action)
    if not is_service:
        return Permission((Verb.SUBSCRIBE,), name)
    node, _, service = name.rpartition('/')
    if node and service in READING:
        return Permission((Verb.READ,), node)
    if node and service in SETTING:
        return Permission((Verb.SET,), node)
    return Permission((Verb.CALL,), name)
