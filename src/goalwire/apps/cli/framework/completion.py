"""Completion in bash, zsh and fish, from the parsers and from the live graph."""

from __future__ import annotations

from argparse import Action, Namespace
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.framework import lookup, values
from goalwire.apps.cli.framework.nouns import NOUNS, load
from goalwire.apps.cli.framework.outcome import CommandError
from goalwire.apps.cli.framework.shell_scripts import SCRIPTS, is_plain, quote_words, words_of
from goalwire.apps.cli.framework.verbs import Noun, Verb, verb_parser
from goalwire.patterns import Pattern

if TYPE_CHECKING:
    import goalwire
    from goalwire.graph.graph import Graph

PATIENCE_S = 2.0
"""Seconds that a node may take to list its parameters."""
_NAME = Pattern(r'[A-Za-z0-9_/]+')
"""Valid names of topics, services, actions, nodes and types. A hostile peer may announce others."""
_PARAMETER = Pattern(r'[A-Za-z0-9_./:][A-Za-z0-9_./:-]*')


def completions(shell: str, arguments: Sequence[str]) -> list[str]:
    """Return the completions of the last word, quoted for the shell.

    For an unknown shell only words that need no quotes are returned.
    """
    if shell not in SCRIPTS:
        return [each for each in complete([shell, *arguments]) if is_plain(each)]
    words = words_of(shell, arguments)
    return [] if words is None else list(quote_words(shell, complete(words)))


def complete(words: Sequence[str]) -> list[str]:
    """Return the completions of the last word of a command line."""
    *said, begun = words or ['']
    flags = [word for word in said if not word.startswith('-')]
    if not flags:
        return _beginning(begun, NOUNS)
    if flags[0] not in NOUNS:
        return []
    noun = load(flags[0])
    if noun.is_command:
        return _of_verb(noun, noun.verbs[0], said[said.index(flags[0]) + 1 :], begun)
    verbs = {verb.name: verb for verb in noun.verbs}
    if len(flags) == 1:
        return _beginning(begun, verbs)
    if flags[1] not in verbs:
        return []
    rest = said[said.index(flags[0]) + 1 :]
    return _of_verb(noun, verbs[flags[1]], rest[rest.index(flags[1]) + 1 :], begun)


def _of_verb(noun: Noun, verb: Verb, said: Sequence[str], begun: str) -> list[str]:
    parser = verb_parser('ros2', noun, verb)
    options = {flag: action for action in parser.actions for flag in action.option_strings}
    if said and said[-1] in options and _takes_value(options[said[-1]]):
        return _beginning(begun, map(str, options[said[-1]].choices or ()))
    if begun.startswith('-'):
        return _beginning(begun, options)
    positionals = [action for action in parser.actions if not action.option_strings]
    given: list[str] = []
    for at, word in enumerate(said):
        before = said[at - 1] if at else ''
        if not word.startswith('-') and not (before in options and _takes_value(options[before])):
            given.append(word)
    if not positionals:
        return []
    action = positionals[min(len(given), len(positionals) - 1)]
    if action.choices:
        return _beginning(begun, map(str, action.choices))
    return _live(noun.name, action.dest, given, begun)


def _takes_value(action: Action) -> bool:
    return action.nargs != 0


def _beginning(begun: str, known: Iterable[str]) -> list[str]:
    return sorted(each for each in known if each.startswith(begun))


def _match(begun: str, names: Iterable[str]) -> list[str]:
    """Return the names that begin with `begun`, whose first slash the user may have left out."""
    wanted = begun if begun.startswith('/') else f'/{begun}'
    return sorted({name for name in names if name.startswith(wanted) and _NAME.fullmatch(name)})


def _live(noun: str, what: str, given: Sequence[str], begun: str) -> list[str]:
    """Return candidates for an argument from the graph or the interfaces; [] for other kinds of arguments."""
    from goalwire.apps.cli.framework.nodes import is_hidden, node_names

    names: dict[str, Callable[[Graph], Iterable[str]]] = {
        'service_name': lambda graph: (name for name, _ in graph.service_names_and_types()),
        'action_name': lambda graph: (name for name, _ in graph.action_names_and_types()),
        'topic_name': lambda graph: (name for name, _ in graph.topic_names_and_types()),
        'topic_names': lambda graph: (name for name, _ in graph.topic_names_and_types()),
        'node_name': lambda graph: node_names(graph, include_hidden=False),
    }
    if what in names:
        found = _match(begun, _of_graph(names[what]))
        return [name for name in found if not is_hidden(name) and '/_' not in name]
    if noun == 'param' and what in {'parameter_name', 'parameter_names', 'pairs'}:
        return [name for name in _beginning(begun, _parameters_of(given[0])) if _PARAMETER.fullmatch(name)]
    if what in {'words', 'service_type', 'action_type', 'message_type'} and len(given) == 1:
        return [name for name in _beginning(begun, _types_of(noun, given[0])) if _NAME.fullmatch(name)]
    if what == 'words':
        return _fields(noun, given[1], given[2:], begun)
    if what in {'type', 'topic_type', 'service_type', 'action_type'}:
        kinds = {'topic': ('msg',), 'service': ('srv',), 'action': ('action',)}.get(
            noun, ('msg', 'srv', 'action')
        )
        return _beginning(begun, _interfaces(kinds))
    if noun in {'launch', 'pkg', 'run'}:
        from goalwire.launching import commands

        return _beginning(begun, commands.completions(noun, given, begun))
    if what == 'package_name':
        from rosidl_runtime_py import get_interface_packages

        return _beginning(begun, get_interface_packages())
    return []


def _fields(noun: str, type_name: str, pairs: Sequence[str], begun: str) -> list[str]:
    """Return the fields of a request, goal or message as `name=`, or as `name.` for a nested message."""
    part = {'service': 'Request', 'action': 'Goal'}.get(noun)
    try:
        cls: Any = lookup.interface(type_name)
        cls = getattr(cls, part) if part else cls
    except (CommandError, AttributeError):
        return []
    path, _, _ = begun.rpartition('.')
    for name in path.split('.') if path else ():
        kind = values.field_type(cls, [name])
        if not _is_message(kind):
            return []
        package, _, type_ = kind.partition('/')
        cls = lookup.interface(f'{package}/msg/{type_}')
    known: dict[str, str] = cls.get_fields_and_field_types()
    prefix = f'{path}.' if path else ''
    given = {pair.partition('=')[0] for pair in pairs}
    found = [f'{prefix}{name}{"." if _is_message(kind) else "="}' for name, kind in known.items()]
    return [each for each in found if each.startswith(begun) and each.rstrip('=') not in given]


def _is_message(kind: str) -> bool:
    return '/' in kind and '[' not in kind and '<' not in kind


def _of_graph(question: Callable[[Graph], Iterable[str]]) -> list[str]:
    from goalwire.apps.cli.framework.discovery import discovered

    with discovered(Namespace()) as graph:
        return list(question(graph))


def _parameters_of(given: str) -> list[str]:
    """Ask a node for the names of its parameters."""
    from goalwire.apps.cli.framework.live import live
    from goalwire.apps.cli.framework.nodes import find_node
    from goalwire.observe.parameters import NodeParameters

    name, found = find_node(Namespace(node_name=given)), list[str]()

    async def look(node: goalwire.Node) -> None:
        found.extend(await NodeParameters(node, name, PATIENCE_S).names())

    live(look)
    return found


def _types_of(noun: str, name: str) -> list[str]:
    def question(graph: Graph) -> Iterable[str]:
        found = {
            'service': graph.service_names_and_types,
            'action': graph.action_names_and_types,
            'topic': graph.topic_names_and_types,
        }
        return [kind for each, kinds in found[noun]() if each.strip('/') == name.strip('/') for kind in kinds]

    return _of_graph(question)


def _interfaces(kinds: Sequence[str]) -> list[str]:
    from rosidl_runtime_py import get_interfaces

    return [
        f'{package}/{name}'
        for package, names in get_interfaces().items()
        for name in names
        if name.split('/')[0] in kinds
    ]
