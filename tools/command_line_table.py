"""Writes the table of verbs and flags into its page: python tools/command_line_table.py.

What ROS 2 Jazzy has is data here (of ros2cli 0.32, its later releases included); what goalwire has comes from
its parsers. The page is docs/reference/command-line.md, which tests/docs/test_command_line.py holds to this.
"""

from __future__ import annotations

import sys
from argparse import Action
from collections.abc import Iterable, Iterator
from pathlib import Path

from goalwire.apps.cli.framework import nouns
from goalwire.apps.cli.framework.verbs import Parser, Verb, noun_parser, verb_parser

PAGE = Path(__file__).parents[1] / 'docs' / 'reference' / 'command-line.md'
BEGIN, END = '<!-- verbs: begin -->', '<!-- verbs: end -->'

GRAPH = '--no-daemon --spin-time -s --use-sim-time'
QOS = (
    '--qos-profile --qos-depth --qos-history --qos-reliability --qos-durability --qos-liveliness '
    '--qos-liveliness-lease-duration-seconds'
)
COMPONENT = '-n --node-name --node-namespace --log-level -r --remap-rule -p --parameter -e --extra-argument'
NODE = f'{GRAPH} --include-hidden-nodes'
JAZZY = {
    'action': {
        'info': f'{GRAPH} -t --show-types -c --count',
        'list': f'{GRAPH} -t --show-types -c --count-actions',
        'send_goal': '--stdin -f --feedback -t --timeout',
        'type': GRAPH,
    },
    'bag': {
        'burst': '-s --storage --read-ahead-queue-size --topics --services --qos-profile-overrides-path '
        '-m --remap --storage-config-file --start-offset -n --num-messages',
        'convert': '-i --input -o --output-options',
        'info': '-s --storage -t --topic-name -v --verbose --sort',
        'list': '-v --verbose',
        'play': '-s --storage --read-ahead-queue-size -r --rate --topics --services -e --regex '
        '-x --exclude-regex --exclude-topics --exclude-services --qos-profile-overrides-path -l --loop '
        '-m --remap --storage-config-file --clock --clock-topics --clock-topics-all -d --delay '
        '--playback-duration --playback-until-sec --playback-until-nsec --disable-keyboard-controls '
        '-p --start-paused --start-offset --wait-for-all-acked --disable-loan-message '
        '--publish-service-requests --service-requests-source',
        'reindex': '-s --storage',
        'record': '-o --output -s --storage -f --serialization-format -b --max-bag-size -d '
        '--max-bag-duration --max-cache-size --start-paused --use-sim-time --node-name '
        '--custom-data --snapshot-mode --topics --services --topic-types -a --all --all-topics '
        '--all-services -e --regex --exclude-regex --exclude-topic-types --exclude-topics '
        '--exclude-services --include-unpublished-topics --include-hidden-topics --no-discovery '
        '-p --polling-interval --ignore-leaf-topics --qos-profile-overrides-path '
        '--storage-preset-profile --storage-config-file --log-level --compression-queue-size '
        '--compression-threads --compression-threads-priority --compression-mode '
        '--compression-format --disable-keyboard-controls',
    },
    'component': {
        'list': f'{GRAPH} --containers-only',
        'load': f'{GRAPH} {COMPONENT} -q --quiet',
        'standalone': f'{GRAPH} {COMPONENT} -c --container-node-name',
        'types': '',
        'unload': f'{GRAPH} -q --quiet',
    },
    'doctor': {
        'doctor': '-r --report -rf --report-failed -ep --exclude-packages -iw --include-warnings',
        'hello': '',
    },
    'interface': {
        'list': '-m --only-msgs -s --only-srvs -a --only-actions',
        'package': '-m --only-msgs -s --only-srvs -a --only-actions',
        'packages': '-m --only-msgs -s --only-srvs -a --only-actions',
        'proto': '--no-quotes',
        'show': '--all-comments --no-comments',
    },
    'launch': {
        'launch': '-n --noninteractive -d --debug -p --print --print-description '
        '-s --show-args --show-arguments -a --show-all-subprocesses-output '
        '--launch-prefix --launch-prefix-filter'
    },
    'lifecycle': {
        'get': NODE,
        'list': f'{NODE} -a --all',
        'nodes': f'{GRAPH} -a --all -c --count-nodes',
        'set': NODE,
    },
    'node': {'info': f'{GRAPH} --include-hidden', 'list': f'{GRAPH} -a --all -c --count-nodes'},
    'param': {
        'delete': f'{NODE} --timeout',
        'describe': f'{NODE} --timeout',
        'dump': f'{NODE} --timeout',
        'get': f'{NODE} --timeout --hide-type',
        'list': f'{NODE} --filter --param-prefixes --param-type',
        'load': f'{NODE} --timeout --no-use-wildcard',
        'set': f'{NODE} --timeout',
    },
    'pkg': {'create': '', 'executables': '--full-path', 'list': '', 'prefix': '--share', 'xml': '-t --tag'},
    'run': {'run': '--prefix'},
    'service': {
        'call': '--stdin -r --rate',
        'echo': f'{GRAPH} {QOS} --csv -f --full-length -l --truncate-length --no-arr --no-str --flow-style',
        'find': f'{GRAPH} -c --count-services --include-hidden-services',
        'info': GRAPH,
        'list': f'{GRAPH} -t --show-types -c --count-services --include-hidden-services',
        'type': GRAPH,
    },
    'topic': {
        'bw': f'{GRAPH} -w --window',
        'delay': f'{GRAPH} -w --window',
        'echo': f'{GRAPH} {QOS} --csv --field -f --full-length -l --truncate-length --no-arr --no-str '
        '--flow-style --no-lost-messages --raw --filter --once --timeout -i --include-message-info',
        'find': f'{GRAPH} -c --count-topics --include-hidden-topics',
        'hz': f'{GRAPH} -w --window --filter --wall-time',
        'info': f'{GRAPH} -v --verbose',
        'list': f'{GRAPH} -t --show-types -c --count-topics -v --verbose --include-hidden-topics',
        'pub': f'{GRAPH} {QOS} --stdin -r --rate -p --print -1 --once -t --times '
        '-w --wait-matching-subscriptions --max-wait-time-secs --keep-alive -n --node-name',
        'type': GRAPH,
    },
}
"""The nouns that goalwire's own cover, verb by verb."""

BEFORE = {'service': '--include-hidden-services', 'topic': '--include-hidden-topics'}
"""The options that Jazzy takes between a noun and its verb."""

MISSING = {
    'bag --storage-config-file': '`--storage-preset-profile` has what there is to choose',
    'bag --log-level': '`--ros-args --log-level` has it, as for every command with a node',
    'pkg create': '`new` makes a package for pip, uv and colcon at once',
    'doctor hello': "`doctor`'s self-test does it between two processes",
    'doctor -ep --exclude-packages': 'packages are not compared with a list of releases',
    'doctor -iw --include-warnings': 'what is not well is always shown',
}
"""The options of Jazzy that goalwire lacks, and the reasons."""


def flags(program_verb: tuple[str, str]) -> list[str]:
    """Return the flags of one of goalwire's verbs."""
    noun = nouns.load(program_verb[0])
    verb = next(each for each in noun.verbs if each.name == program_verb[1])
    return [flag for action in _optional(noun.name, verb) for flag in action.option_strings]


def _optional(noun_name: str, verb: Verb) -> list[Action]:
    return _with_flags(verb_parser('ros2', nouns.load(noun_name), verb))


def _with_flags(parser: Parser) -> list[Action]:
    return [each for each in parser.actions if each.option_strings and '--help' not in each.option_strings]


def _before(noun_name: str) -> list[Action]:
    """Return the flags between a noun and its verb."""
    noun = nouns.load(noun_name)
    return [] if noun.is_command else _with_flags(noun_parser('ros2', noun))


def missing() -> list[str]:
    """Return what Jazzy has and goalwire has not: 'noun verb', or 'noun --flag'."""
    found = []
    for name, verbs in JAZZY.items():
        before = {flag for action in _before(name) for flag in action.option_strings}
        found += [f'{name} {flag}' for flag in BEFORE.get(name, '').split() if flag not in before]
        ours = {verb.name for verb in nouns.load(name).verbs}
        for verb, wanted in verbs.items():
            if verb not in ours:
                found.append(f'{name} {verb}')
                continue
            own = set(flags((name, verb)))
            lacking = [flag for flag in wanted.split() if flag not in own]
            found += [f'{name} {" ".join(pair)}' for pair in _pairs(lacking)]
    return found


def _pairs(lacking: list[str]) -> Iterator[list[str]]:
    """Yield short and long form of a flag together."""
    rest = list(lacking)
    while rest:
        flag = rest.pop(0)
        if not flag.startswith('--') and rest and rest[0].startswith('--'):
            yield [flag, rest.pop(0)]
        else:
            yield [flag]


def table() -> str:
    """Return the two tables in Markdown."""
    lines = ['| command | flags as in Jazzy | besides |', '|---|---|---|']
    for name in nouns.NOUNS:
        if flags_before := _before(name):
            lines.append(_row(f'`{name}`, before the verb', flags_before, BEFORE.get(name, '')))
        for verb in nouns.load(name).verbs:
            title = name if nouns.load(name).is_command else f'{name} {verb.name}'
            mark = '' if name in JAZZY and verb.name in JAZZY[name] else ' ▲'
            theirs = JAZZY.get(name, {}).get(verb.name, '')
            lines.append(_row(f'`{title}`{mark}', _optional(name, verb), theirs))
    lines += ['', '| Jazzy has | why it is not here |', '|---|---|']
    lines += [f'| `{what}` | {MISSING[what]} |' for what in missing()]
    return '\n'.join(lines)


def _row(title: str, actions: Iterable[Action], theirs: str) -> str:
    """Return one line of the table; `theirs` are the flags that Jazzy has."""
    shared: list[str] = []
    own: list[str] = []
    for action in actions:
        text = ', '.join(f'`{flag}`' for flag in action.option_strings)
        (shared if set(action.option_strings) & set(theirs.split()) else own).append(text)
    return f'| {title} | {" ".join(shared)} | {" ".join(own)} |'


def page() -> str:
    """Return the page with the tables as they are to be."""
    text = PAGE.read_text(encoding='utf-8')
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    return f'{before}{BEGIN}\n{table()}\n{END}{after}'


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
    sys.exit(0)
