"""Tells hidden names from others, and finds the names that belong to an action."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from goalwire.rules.names.validation import is_hidden_name

NamesAndTypes: TypeAlias = list[tuple[str, list[str]]]
"""Names in alphabetical order, each with its types in alphabetical order."""

_FEEDBACK = '/_action/feedback'
_FEEDBACK_TYPE = '_FeedbackMessage'
SEND_GOAL = '/_action/send_goal'
_SEND_GOAL_TYPE = '_SendGoal'


def without_hidden(names_and_types: NamesAndTypes) -> NamesAndTypes:
    """Return the list without hidden names, as ROS 2's tools show it by default."""
    return [(name, types) for name, types in names_and_types if not is_hidden_name(name)]


def actions_among(topics: Iterable[tuple[str, list[str]]]) -> NamesAndTypes:
    """Return the actions whose feedback topics are in a list of topics, as rcl_action does."""
    return [
        (name.removesuffix(_FEEDBACK), [type_name.removesuffix(_FEEDBACK_TYPE) for type_name in types])
        for name, types in topics
        if name.endswith(_FEEDBACK)
    ]


def is_part_of_action(name: str) -> bool:
    """Return whether a service or topic belongs to an action."""
    return '/_action/' in name


def show_type(type_name: str) -> str:
    """Return a type's name as users see it: for the type of a send_goal service, the action's type."""
    return type_name.removesuffix(_SEND_GOAL_TYPE) if '/action/' in type_name else type_name
