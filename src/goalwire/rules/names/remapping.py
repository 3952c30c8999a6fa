"""Remap rules: `from:=to`, `node:from:=to`, `__node:=name`, `__ns:=/namespace` (rcl/remap.h).

The first rule that matches wins, and its result is not remapped again. A node's name is remapped first. Rules
with the prefix `node:` for namespaces, topics and services then apply to the node with this new name.
"""

from __future__ import annotations

from enum import Flag, auto
from typing import TYPE_CHECKING

from goalwire.records import record
from goalwire.rules.names.expansion import expand_topic_name
from goalwire.rules.names.lexer import Lexeme, Lexer, RuleSyntaxError, node_prefix, refuse_wildcard

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


class Remaps(Flag):
    """The kinds of names that a rule may rename."""

    NODE = auto()
    NAMESPACE = auto()
    TOPIC = auto()
    SERVICE = auto()


@record
class RemapRule:
    """A remap rule.

    `match` is '' in rules for node names and namespaces. `node` limits the rule to the node of that name.
    """

    remaps: Remaps
    match: str
    replacement: str
    node: str | None = None


class RemapRules:
    """The remap rules for one node. The node's own rules come before those of the process."""

    def __init__(self, rules: Iterable[RemapRule] = ()) -> None:
        self._rules = tuple(rules)

    def node_name(self, name: str) -> str:
        """Return the remapped name of the node `name`."""
        return self._whole(Remaps.NODE, name) or name

    def namespace(self, namespace: str, node_name: str) -> str:
        """Return the namespace of the node whose name, already remapped, is `node_name`."""
        return self._whole(Remaps.NAMESPACE, node_name) or namespace

    def topic(self, full_name: str, node_name: str, namespace: str) -> str:
        """Return the absolute name that replaces the topic `full_name` in this node."""
        return self._name(Remaps.TOPIC, full_name, node_name, namespace)

    def service(self, full_name: str, node_name: str, namespace: str) -> str:
        """Return the absolute name that replaces the service `full_name` in this node."""
        return self._name(Remaps.SERVICE, full_name, node_name, namespace)

    def _whole(self, remaps: Remaps, node_name: str) -> str | None:
        return next((rule.replacement for rule in self._for(remaps, node_name)), None)

    def _name(self, remaps: Remaps, full_name: str, node_name: str, namespace: str) -> str:
        for rule in self._for(remaps, node_name):
            if expand_topic_name(rule.match, node_name, namespace) == full_name:
                return expand_topic_name(rule.replacement, node_name, namespace)
        return full_name

    def _for(self, remaps: Remaps, node_name: str) -> Iterator[RemapRule]:
        return (rule for rule in self._rules if remaps in rule.remaps and rule.node in {None, node_name})


def parse_remap_rule(text: str) -> RemapRule:
    """Read one remap rule; raises RuleSyntaxError with ROS 2's text."""
    lexer = Lexer(text)
    node = node_prefix(lexer)
    kind = lexer.peek()
    if kind is Lexeme.NODE:
        return RemapRule(Remaps.NODE, '', _replacement_of_node(lexer), node)
    if kind is Lexeme.NS:
        return RemapRule(Remaps.NAMESPACE, '', _replacement_of_namespace(lexer), node)
    remaps = _scheme(lexer)
    match = _match(lexer)
    lexer.expect(Lexeme.SEPARATOR)
    return RemapRule(remaps, match, _replacement(lexer), node)


def _scheme(lexer: Lexer) -> Remaps:
    if lexer.accept({Lexeme.URL_SERVICE}):
        return Remaps.SERVICE
    if lexer.accept({Lexeme.URL_TOPIC}):
        return Remaps.TOPIC
    return Remaps.TOPIC | Remaps.SERVICE


def _replacement_of_node(lexer: Lexer) -> str:
    lexer.expect(Lexeme.NODE)
    lexer.expect(Lexeme.SEPARATOR)
    name = lexer.expect(Lexeme.TOKEN)
    lexer.expect(Lexeme.EOF)
    return name


def _replacement_of_namespace(lexer: Lexer) -> str:
    lexer.expect(Lexeme.NS)
    lexer.expect(Lexeme.SEPARATOR)
    namespace = lexer.expect(Lexeme.FORWARD_SLASH)
    while token := lexer.accept({Lexeme.TOKEN}):
        namespace += token + lexer.accept({Lexeme.FORWARD_SLASH})
    lexer.expect(Lexeme.EOF)
    return namespace


def _match(lexer: Lexer) -> str:
    name = lexer.accept({Lexeme.TILDE_SLASH, Lexeme.FORWARD_SLASH}) + _match_token(lexer)
    while lexer.peek() is not Lexeme.SEPARATOR:
        name += lexer.expect(Lexeme.FORWARD_SLASH) + _match_token(lexer)
    return name


def _match_token(lexer: Lexer) -> str:
    refuse_wildcard(lexer)
    if not (token := lexer.accept({Lexeme.TOKEN})):
        raise RuleSyntaxError('Expecting token or wildcard')
    return token


def _replacement(lexer: Lexer) -> str:
    name = lexer.accept({Lexeme.TILDE_SLASH, Lexeme.FORWARD_SLASH}) + _replacement_token(lexer)
    while lexer.peek() is not Lexeme.EOF:
        name += lexer.expect(Lexeme.FORWARD_SLASH) + _replacement_token(lexer)
    return name


def _replacement_token(lexer: Lexer) -> str:
    if lexer.accept({Lexeme.BACKREFERENCE}):
        raise RuleSyntaxError('Backreferences are not implemented')
    if not (token := lexer.accept({Lexeme.TOKEN})):
        # ROS 2 sets no text for this error, and prints "error not set".
        raise RuleSyntaxError('error not set')
    return token
