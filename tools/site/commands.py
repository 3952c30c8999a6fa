"""The reference of the command line: a page for each noun, from the parsers themselves."""

from __future__ import annotations

import argparse
from pathlib import Path

from goalwire.apps.cli.framework import nouns
from goalwire.apps.cli.framework.verbs import Noun, Parser, Verb, noun_parser, verb_parser


def write_commands(folder: Path) -> None:
    """Write a page for each noun, and one that lists them."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = [
        '# All commands',
        '',
        '`ros2` and `goalwire` are one program. [How it is used](../reference/command-line.md).',
        '',
    ]
    lines += ['| command | what it does |', '|---|---|']
    for name, (_, summary) in nouns.NOUNS.items():
        lines.append(f'| [`{name}`]({name}.md) | {summary} |')
        (folder / f'{name}.md').write_text(_page(nouns.load(name)), encoding='utf-8')
    lines += ['', '```{toctree}', ':hidden:', '', *nouns.NOUNS, '```', '']
    (folder / 'index.md').write_text('\n'.join(lines), encoding='utf-8')


def _page(noun: Noun) -> str:
    parts = [f'# goalwire {noun.name}', '', f'{noun.summary}.', '']
    if not noun.is_command:
        before = _options(noun_parser('goalwire', noun))
        if before:
            parts += ['Before the verb:', '', *before, '']
    for verb in noun.verbs:
        parts += _verb(noun, verb)
    return '\n'.join(parts)


def _verb(noun: Noun, verb: Verb) -> list[str]:
    parser = verb_parser('goalwire', noun, verb)
    usage = ' '.join(parser.format_usage().split()).removeprefix('usage: ')
    title = [] if noun.is_command else [f'## {verb.name}', '', f'{verb.summary}.', '']
    return [*title, '```text', usage, '```', '', *_options(parser), '']


def _options(parser: Parser) -> list[str]:
    """Return a table of what a parser takes."""
    rows = []
    for action in parser.actions:
        if '--help' in action.option_strings or action.help is argparse.SUPPRESS:
            continue
        names = (
            ', '.join(f'`{name}`' for name in action.option_strings) or f'`{action.metavar or action.dest}`'
        )
        expanded = (action.help or '').replace('%(default)s', str(action.default)).replace('%%', '%')
        rows.append(f'| {names} | {expanded.replace("|", "&#124;").replace("<", "&lt;")} |')
    return ['| argument | what it does |', '|---|---|', *rows] if rows else []
