"""Finds parameter overrides that no node has used; they are reported once, at the end of the program.

Some unused overrides may be intended, since programs may share a parameter file. So values of a file below
wildcards are not reported. Values of a file for nodes of other programs are not reported, either, if the file
also has values for a node of this program.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.files import show
from goalwire.rules.arguments import ParameterFile, ParameterOverride
from goalwire.rules.parameters.file_syntax import matches

if TYPE_CHECKING:
    from goalwire.rules.arguments import Arguments

_LONGEST_SHOWN = 100  # the most characters of a name in a report
_MOST_SHOWN = 5  # the most names in one line of a report


class OverrideUse:
    """Compares the parameters that a process's nodes have declared with the overrides of its command line."""

    def __init__(self, arguments: Arguments) -> None:
        self._given = arguments.parameters
        self._declared: dict[str, set[str]] = {}
        self._lock = Lock()
        self._told: set[str] = set()

    def note_node(self, full_name: str) -> None:
        """Note that the process has a node of this fully qualified name."""
        with self._lock:
            self._declared.setdefault(full_name, set())

    def declared(self, full_name: str, parameter: str) -> None:
        """Note that a node declared a parameter."""
        with self._lock:
            self._declared.setdefault(full_name, set()).add(parameter)

    def describe_unused(self) -> list[str]:
        """Return a sentence for each override that no node has used; [] if the process never had a node."""
        if not self._declared:
            return []
        found: dict[str, None] = {}
        for item in self._given:
            found.update(
                dict.fromkeys(self._of_file(item) if isinstance(item, ParameterFile) else self._of(item))
            )
        return [told for told in found if told not in self._told]

    def describe_misspelt(self) -> list[str]:
        """Return sentences about misspelt names of overrides, and about files that are for other nodes only.

        A name counts as misspelt if it resembles a declared name. Each sentence is returned only once: by
        this method or by `describe_unused`.
        """
        found = [told for told in self.describe_unused() if 'did you mean' in told or 'it is for' in told]
        self._told.update(found)
        return found

    def _of(self, item: ParameterOverride) -> Iterator[str]:
        rule = f'-p {item.node}:{item.name}:=…' if item.node else f'-p {item.name}:=…'
        nodes = self._find_meant(item.node or '/**')
        if not nodes:
            yield f"nothing used '{_short(rule)}': there was no node /{item.node}{self._describe_made()}"
        elif not self._is_declared(item.name, nodes):
            yield f"nothing used '{_short(rule)}': {self._undeclared([item.name], nodes)}"

    def _of_file(self, file: ParameterFile) -> Iterator[str]:
        meant = {pattern: self._find_meant(pattern) for pattern in file.nodes}
        if meant and not any(meant.values()):
            made = self._describe_made()
            yield (
                f"nothing used '--params-file {show(file.path)}': it is for {_some(meant)}{made}: "
                'give both the same name'
            )
        for pattern, nodes in meant.items():
            missing = [name for name in file.nodes[pattern] if not self._is_declared(name, nodes)]
            if nodes and missing and '*' not in pattern:
                place = f"'--params-file {show(file.path)}', {_short(pattern)}"
                yield f'nothing used all of {place}: {self._undeclared(missing, nodes)}'

    def _find_meant(self, pattern: str) -> list[str]:
        return [node for node in self._declared if matches(pattern, node)]

    def _is_declared(self, name: str, nodes: Collection[str]) -> bool:
        return any(name in self._declared[node] for node in nodes)

    def _undeclared(self, names: Collection[str], nodes: Collection[str]) -> str:
        from difflib import get_close_matches

        known = {name for node in nodes for name in self._declared[node]}
        close = [match for name in names for match in get_close_matches(name[:_LONGEST_SHOWN], known, n=1)]
        hint = f'; did you mean {_some(close)}?' if close else ''
        who = f'{_some(nodes)} did not declare' if len(nodes) == 1 else 'no node declared'
        return f'{who} {_some(names)}{hint}'

    def _describe_made(self) -> str:
        return f'; this program made {_some(self._declared)}'


def _short(text: str) -> str:
    return show(text, _LONGEST_SHOWN)


def _some(names: Collection[str]) -> str:
    shortened = [_short(name) for name in list(names)[:_MOST_SHOWN]]
    more = [f'{len(names) - _MOST_SHOWN} more'] if len(names) > _MOST_SHOWN else []
    return ', '.join([*shortened, *more])
