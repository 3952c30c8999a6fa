"""Which nouns there are, and which module has each. Nothing is imported before it is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.cli.verbs import Noun

NOUNS = {
    'action': ('goalwire.cli.action', 'Various action related sub-commands'),
    'check': ('goalwire.cli.check', 'Check interface files and launch files'),
    'launch': ('goalwire.cli.launch', 'Run a launch file'),
    'pkg': ('goalwire.cli.pkg', 'Various package related sub-commands'),
    'run': ('goalwire.cli.run', 'Run a package specific executable'),
    'service': ('goalwire.cli.service', 'Various service related sub-commands'),
}
"""Module and summary by name, in the order of `--help`. The module's NOUN has the same summary."""


def load(name: str) -> Noun:
    """Import a noun of NOUNS."""
    noun: Noun = import_module(NOUNS[name][0]).NOUN
    return noun
