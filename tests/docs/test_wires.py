"""The docs tell how a wire differs: their table has the same differences as the tests' marks."""

from __future__ import annotations

import ast

from helpers.markdown import DOCS, ROOT, rows


def constants(tree: ast.Module) -> dict[str, object]:
    """Return the names that a module gives to constants."""
    return {
        target.id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name)
    }


def marks() -> set[object]:
    """Return what the tests are marked with that do not run on DDS."""
    found: set[object] = set()
    for file in [*ROOT.glob('tests/**/test_*.py'), *ROOT.glob('robot/*/tests/**/test_*.py')]:
        if 'differs_on' not in (text := file.read_text(encoding='utf-8')):
            continue
        tree = ast.parse(text)
        named = constants(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, 'attr', '') == 'differs_on':
                what = node.args[1]
                found.add(named[what.id] if isinstance(what, ast.Name) else ast.literal_eval(what))
    return found


def test_the_table_of_differences_is_that_of_the_marks() -> None:
    assert {row[0] for row in rows(DOCS / 'how-to' / 'dds.md', 'on DDS')} == marks()
