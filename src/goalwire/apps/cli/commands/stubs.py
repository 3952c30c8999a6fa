"""goalwire stubs: writes type stubs for your own packages to a folder that type checkers search."""

from __future__ import annotations

import os
import sys
import sysconfig
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

SUMMARY = 'Write type stubs of your own packages into the active environment'
STUB_PACKAGE = '-stubs'
"""PEP 561: checkers look for <package>-stubs beside installed packages."""


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        'packages', nargs='*', help='Packages with interfaces (default: all that are found here)'
    )
    parser.add_argument('--directory', help="Where to write (default: the environment's site-packages)")
    parser.add_argument(
        '--plain-names',
        action='store_true',
        help='Name the folders PACKAGE, as a folder of stubs of your own has them, and not PACKAGE-stubs',
    )


def write_stubs_of_packages(arguments: Namespace, output: Output) -> Outcome:
    """Write the stubs of the named packages, or of all that are found. Raises CommandError."""
    from goalwire.idl.stubs import own_packages

    folder = Path(arguments.directory) if arguments.directory else environment_folder()
    packages = arguments.packages or own_packages()
    if not packages:
        raise CommandError(
            Outcome.NOT_FOUND,
            f'{arguments.prog}: no package with interfaces of your own was found here',
            'start it in your workspace, or name the package in GOALWIRE_INTERFACE_PATH',
        )
    suffix = '' if arguments.plain_names else STUB_PACKAGE
    return write_into(folder, packages, output, suffix=suffix)


def write_into(folder: Path, packages: list[str], output: Output, *, suffix: str = STUB_PACKAGE) -> Outcome:
    """Write stubs, and print which files were written and which definitions were skipped.

    Raises CommandError if a package is missing, or nothing can be written to the folder.
    """
    from goalwire.errors import InterfaceError
    from goalwire.idl.stubs import write_stubs

    broken: list[InterfaceError] = []
    try:
        files = write_stubs(folder, packages, suffix=suffix, broken=broken)
    except InterfaceError as error:
        raise CommandError(Outcome.NOT_FOUND, str(error), 'see: ros2 interface packages') from None
    except OSError as error:
        advice = 'activate an environment that is yours, or name another folder'
        raise CommandError(Outcome.FAILED, f"cannot write to '{folder}': {error.strerror}", advice) from None
    if output.json:
        told = [str(error) for error in broken]
        output.data({'packages': packages, 'files': sorted(map(str, files)), 'passed_over': told})
    else:
        for each in broken:
            output.line(f'passed over: {each}')
        output.line(f'{len(files)} files in {folder}, for: {", ".join(packages)}')
    return Outcome.FAILED if broken else Outcome.OK


def environment_folder() -> Path:
    """Return the site-packages of the active environment, else that of this Python."""
    active = os.environ.get('VIRTUAL_ENV')
    if active and Path(active).resolve() != Path(sys.prefix).resolve():
        found = sorted(Path(active).glob('[Ll]ib/**/site-packages'))
        if found:
            return found[0]
    return Path(sysconfig.get_path('purelib'))


NOUN = Noun('stubs', SUMMARY, (Verb('stubs', SUMMARY, write_stubs_of_packages, _arguments),))
