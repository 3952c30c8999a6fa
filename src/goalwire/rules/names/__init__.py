"""ROS 2's rules for names: validation, expansion and remapping."""

from goalwire.rules.names.actions import ActionNames
from goalwire.rules.names.expansion import (
    absolute_namespace,
    expand_topic_name,
    join,
    qualify_topic_name,
)
from goalwire.rules.names.lexer import RuleSyntaxError
from goalwire.rules.names.remapping import RemapRule, RemapRules, Remaps, parse_remap_rule
from goalwire.rules.names.validation import (
    InvalidName,
    UnknownSubstitution,
    is_hidden_name,
    validate_enclave,
    validate_full_topic_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)

__all__ = [
    'ActionNames',
    'InvalidName',
    'RemapRule',
    'RemapRules',
    'Remaps',
    'RuleSyntaxError',
    'UnknownSubstitution',
    'absolute_namespace',
    'expand_topic_name',
    'is_hidden_name',
    'join',
    'parse_remap_rule',
    'qualify_topic_name',
    'validate_enclave',
    'validate_full_topic_name',
    'validate_namespace',
    'validate_node_name',
    'validate_topic_name',
]
