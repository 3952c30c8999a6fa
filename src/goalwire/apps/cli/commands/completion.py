"""ros2 completion: prints a script by which a shell completes these commands."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.shell_scripts import SCRIPTS
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument('shell', choices=sorted(SCRIPTS), help='Which shell')
    parser.epilog = (
        'bash, zsh: eval "$(ros2 completion bash)" in ~/.bashrc; fish: ros2 completion fish | source'
    )


def _completion(arguments: Namespace, output: Output) -> None:
    output.block(SCRIPTS[arguments.shell], end='')


_SUMMARY = 'Print what makes a shell complete these commands'
NOUN = Noun('completion', _SUMMARY, (Verb('completion', _SUMMARY, _completion, _arguments, has_json=False),))
