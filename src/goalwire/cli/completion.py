"""Completion in bash, zsh and fish, from the parsers and from the live graph."""

from __future__ import annotations

from argparse import Action, ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from goalwire.cli.nouns import NOUNS, load
from goalwire.cli.verbs import Noun, Verb, verb_parser

if TYPE_CHECKING:
    import goalwire
    from goalwire.cli.output import Output
    from goalwire.graph.graph import Graph

PATIENCE_S = 2.0
"""How long a node may take to say its parameters."""
SCRIPTS = {  # each calls `ros2 _complete WORD …`, the last of which is being written
    'bash': """_goalwire_complete() {
    local IFS=$'\\n'
    COMPREPLY=($("${COMP_WORDS[0]}" _complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null))
}
complete -o default -F _goalwire_complete ros2 goalwire
""",
    'zsh': """_goalwire_complete() {
    local -a found
    found=("${(@f)$("${words[1]}" _complete "${(@)words[2,CURRENT]}" 2>/dev/null)}")
    (( ${#found} )) && [[ -n "${found[1]}" ]] && compadd -- "${found[@]}" || _files
}
(( $+functions[compdef] )) || { autoload -Uz compinit && compinit; }
compdef _goalwire_complete ros2 goalwire
""",
    'fish': """for program in ros2 goalwire
    complete -c $program -f -a \\
        "(set -l said (commandline -opc); $program _complete \\$said[2..] (commandline -ct) 2>/dev/null)"
end
""",
}


def complete(words: Sequence[str]) -> list[str]:
    """Return what the last of these words may become."""
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
    return _beginning(begun, _live(noun.name, action.dest, given))


def _takes_value(action: Action) -> bool:
    return action.nargs != 0


def _beginning(begun: str, known: Iterable[str]) -> list[str]:
    return sorted(each for each in known if each.startswith(begun))


def _live(noun: str, what: str, given: Sequence[str]) -> list[str]:
    """Return what the graph, or the interfaces, have for an argument; [] where nothing is known of it."""
    from goalwire.cli.nodes import is_hidden, node_names

    names: dict[str, Callable[[Graph], Iterable[str]]] = {
        'service_name': lambda graph: (name for name, _ in graph.service_names_and_types()),
        'action_name': lambda graph: (name for name, _ in graph.action_names_and_types()),
        'topic_name': lambda graph: (name for name, _ in graph.topic_names_and_types()),
        'topic_names': lambda graph: (name for name, _ in graph.topic_names_and_types()),
        'node_name': lambda graph: node_names(graph, include_hidden=False),
    }
    if what in names:
        return [name for name in _of_graph(names[what]) if not is_hidden(name) and '/_' not in name]
    if noun == 'param' and what in {'parameter_name', 'parameter_names', 'pairs'}:
        return _parameters_of(given[0])
    if what in {'words', 'service_type', 'action_type', 'message_type'} and len(given) == 1:
        return _types_of(noun, given[0])
    if what in {'type', 'topic_type', 'service_type', 'action_type'}:
        kinds = {'topic': ('msg',), 'service': ('srv',), 'action': ('action',)}.get(
            noun, ('msg', 'srv', 'action')
        )
        return _interfaces(kinds)
    if noun in {'launch', 'pkg', 'run'}:
        from goalwire.launching.commands import completions

        return completions(noun, given)
    if what == 'package_name':
        from rosidl_runtime_py import get_interface_packages

        return list(get_interface_packages())
    return []


def _of_graph(question: Callable[[Graph], Iterable[str]]) -> list[str]:
    from goalwire.cli.discovery import discovered

    with discovered(Namespace()) as graph:
        return list(question(graph))


def _parameters_of(given: str) -> list[str]:
    """Return the parameters of a node, which must say them itself."""
    from goalwire.cli.live import live
    from goalwire.cli.nodes import named_node
    from goalwire.cli.param import names_of

    arguments = Namespace(node_name=given, service_timeout=PATIENCE_S)
    name, found = named_node(arguments), list[str]()

    async def look(node: goalwire.Node) -> None:
        found.extend(await names_of(node, name, arguments))

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


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument('shell', choices=sorted(SCRIPTS), help='Which shell')
    parser.epilog = (
        'bash, zsh: eval "$(ros2 completion bash)" in ~/.bashrc; fish: ros2 completion fish | source'
    )


def _completion(arguments: Namespace, output: Output) -> None:
    output.block(SCRIPTS[arguments.shell], end='')


_SUMMARY = 'Print what makes a shell complete these commands'
NOUN = Noun('completion', _SUMMARY, (Verb('completion', _SUMMARY, _completion, _arguments, has_json=False),))
