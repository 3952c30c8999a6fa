"""The contribution guide names files, folders, commands and variables that there are."""

from __future__ import annotations

import re
from pathlib import Path

from helpers.markdown import ROOT, blocks, rows

PAGE = ROOT / 'CONTRIBUTING.md'
TEXT = PAGE.read_text(encoding='utf-8')
PATH = re.compile(r'(?:src|tests|docs|benchmarks|examples|robot|tools|\.ci)(?:/[\w./]+)?')


def named() -> set[str]:
    """Return the words between backticks on the page, words of commands too."""
    return {word for text in re.findall(r'`([^`\n]+)`', TEXT) for word in text.split()}


def test_every_file_and_folder_that_it_names_is_there() -> None:
    words = named() | {word for block in blocks(PAGE) for word in block.text.split()}
    paths = {word for word in words if PATH.fullmatch(word)}
    assert len(paths) > 30
    placeholders = {'tests/x/test_y.py', 'src/goalwire/x/y.py'}
    assert [path for path in sorted(paths - placeholders) if not (ROOT / path).exists()] == []


def test_every_goal_of_make_that_it_names_is_in_the_makefile() -> None:
    commands = re.findall(r'`make ([a-z -]+)', TEXT) + re.findall(
        r'^make ([a-z -]+?) *(?:#|$)', TEXT, re.MULTILINE
    )
    goals = {goal for command in commands for goal in command.split()}
    there = re.findall(r'^([\w-]+):', (ROOT / 'Makefile').read_text(encoding='utf-8'), re.MULTILINE)
    assert len(goals) > 6
    assert goals <= set(there)


def test_every_folder_of_tests_has_its_place() -> None:
    source = {each.name for each in (ROOT / 'src' / 'goalwire').iterdir() if each.is_dir()}
    files = [each.relative_to(ROOT / 'tests') for each in (ROOT / 'tests').rglob('test_*.py')]
    folders = {file.parts[0] for file in files if len(file.parts) > 1}
    elsewhere = folders - source - {'helpers', 'benchmarks'}
    table = {word for first, _ in rows(PAGE, 'folder') for word in re.findall(r'`tests/(\w+)`', first)}
    second = TEXT[TEXT.index('Tests that belong to no single module') :]
    assert elsewhere <= table | set(re.findall(r'`tests/(\w+)`', second))


def test_every_variable_that_widens_a_run_is_read_somewhere() -> None:
    files = [*(ROOT / 'tests').rglob('*.py'), *(ROOT / 'src').rglob('*.py')]
    text = ''.join(file.read_text(encoding='utf-8') for file in files if file != Path(__file__))
    variables = set(re.findall(r'`(GOALWIRE_\w+)`', TEXT))
    assert len(variables) > 5
    assert [name for name in variables if f"'{name}'" not in text] == []
