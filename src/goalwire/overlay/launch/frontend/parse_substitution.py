"""launch.frontend.parse_substitution: offers the names of ROS 2's module of this name."""

from goalwire.launching.notation import (
    parse_if_substitutions,
    parse_substitution,
    replace_escaped_characters,
)

__all__ = [
    'parse_if_substitutions',
    'parse_substitution',
    'replace_escaped_characters',
]
