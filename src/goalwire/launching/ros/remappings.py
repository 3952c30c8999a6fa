"""Remapping rules as launch files write them: pairs of texts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias

from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import SomeSubstitutions, Substitution
from goalwire.launching.values import normalize_to_list_of_substitutions

SomeRemapRules: TypeAlias = Iterable[tuple[SomeSubstitutions, SomeSubstitutions]]
RemapRule: TypeAlias = tuple[tuple[Substitution, ...], tuple[Substitution, ...]]


def normalize_remap_rule(remap_rule: Any) -> RemapRule:
    """Turn both sides of a remapping rule into substitutions. Raises TypeError for anything but a pair."""
    if not (isinstance(remap_rule, tuple) and len(remap_rule) == 2):
        raise TypeError(f"a remapping rule is a pair, as in ('from', 'to'), not {remap_rule!r:.100}")
    source, target = remap_rule
    return (
        tuple(normalize_to_list_of_substitutions(source)),
        tuple(normalize_to_list_of_substitutions(target)),
    )


def normalize_remap_rules(remap_rules: SomeRemapRules | str) -> Iterable[RemapRule]:
    """Turn several remapping rules into substitutions. Raises TypeError for anything but pairs."""
    if isinstance(remap_rules, str):
        raise TypeError(f"remappings are a list of pairs, as in [('from', 'to')], not {remap_rules!r:.100}")
    return [normalize_remap_rule(rule) for rule in remap_rules]


def parse_remappings(entities: Iterable[Entity], parser: Parser) -> list[tuple[Any, Any]]:
    """Read the <remap> tags of a node."""
    found = []
    for entity in entities:
        found.append(
            (
                parser.parse_substitution(entity.get_attr('from')),
                parser.parse_substitution(entity.get_attr('to')),
            )
        )
        entity.assert_entity_completely_parsed()
    return found
