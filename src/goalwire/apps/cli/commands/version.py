"""ros2 version: the versions of goalwire, of Python and of the wires' libraries."""

from __future__ import annotations

import platform
from argparse import Namespace
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_PARTS = ('eclipse-zenoh', 'cyclonedds', 'numpy', 'PyYAML', 'xxhash')


def versions() -> dict[str, str]:
    """Return versions by name; '' for a package that is not installed."""
    found = {'goalwire': goalwire.__version__, 'Python': platform.python_version()}
    for name in _PARTS:
        try:
            found[name] = version_of(name)
        except PackageNotFoundError:
            found[name] = ''
    return found


def _version(_arguments: Namespace, output: Output) -> None:
    found = versions()
    if output.json:
        output.data({name: version or None for name, version in found.items()})
        return
    for name, version in found.items():
        output.line(f'{name} {version or "(not installed)"}')


NOUN = Noun(
    'version', 'Show which version this is', (Verb('version', 'Show which version this is', _version),)
)
