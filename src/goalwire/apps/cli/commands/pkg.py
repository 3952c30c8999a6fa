"""ros2 pkg: list, prefix, executables, xml."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

SUMMARY = 'Various package related sub-commands'


def _name_argument(parser: ArgumentParser) -> None:
    parser.add_argument('package_name', help='Name of the package')


def _explain_not_found(arguments: Namespace, error: Exception) -> CommandError:
    return CommandError(Outcome.NOT_FOUND, f'{arguments.prog}: {error}')


def _list(_: Namespace, output: Output) -> None:
    from goalwire.launching import packages

    names = packages.names()
    if output.json:
        output.data(names)
        return
    for name in names:
        output.line(name)


def _prefix_arguments(parser: ArgumentParser) -> None:
    _name_argument(parser)
    parser.add_argument('--share', action='store_true', help="Show the folder of the package's own files")


def _prefix(arguments: Namespace, output: Output) -> None:
    from goalwire.errors import NoSuchPackageError
    from goalwire.launching import packages

    try:
        find = packages.share if arguments.share else packages.prefix
        found = find(arguments.package_name)
    except NoSuchPackageError as error:
        raise _explain_not_found(arguments, error) from error
    output.show({'package': arguments.package_name, 'share' if arguments.share else 'prefix': found}, found)


def _of_package(parser: ArgumentParser) -> None:
    parser.add_argument('package_name', nargs='?', help='Name of the package (default: all)')
    parser.add_argument('--full-path', action='store_true', help='Show the path of each executable')


def _executables(arguments: Namespace, output: Output) -> None:
    from goalwire.errors import NoSuchPackageError
    from goalwire.launching import packages

    names = [arguments.package_name] if arguments.package_name else packages.names()
    for name in names:
        try:
            paths = packages.executables(name)
        except NoSuchPackageError as error:
            raise _explain_not_found(arguments, error) from error
        for path in paths:
            base = os.path.basename(path)
            if output.json:
                output.data({'package': name, 'executable': base, 'path': path})
            elif arguments.full_path:
                output.line(path)
            else:
                output.line(f'{name} {base}')


def _xml_arguments(parser: ArgumentParser) -> None:
    _name_argument(parser)
    parser.add_argument('-t', '--tag', help='Show only the text of this tag, e.g. version')


def _xml(arguments: Namespace, output: Output) -> None:
    from goalwire.errors import NoSuchPackageError
    from goalwire.files import read_regular, show
    from goalwire.launching import packages

    try:
        path = os.path.join(packages.share(arguments.package_name), 'package.xml')
    except NoSuchPackageError as error:
        raise _explain_not_found(arguments, error) from error
    try:
        text = read_regular(path, 2**20).decode('utf-8', 'replace')
    except OSError as error:
        problem = f"{arguments.prog}: package '{arguments.package_name}' has no readable package.xml"
        raise CommandError(Outcome.NOT_FOUND, f'{problem}: {show(path)}: {error.strerror}') from error
    if arguments.tag:
        found = _texts(text, arguments.tag, path)
        if not found:
            raise CommandError(
                Outcome.NOT_FOUND, f"{arguments.prog}: there is no tag '{arguments.tag}' in {show(path)}"
            )
        text = '\n'.join(found)
    if output.json:
        output.data({'package': arguments.package_name, 'path': path, 'xml': text})
    else:
        output.block(text.rstrip('\n'))


def _texts(xml: str, tag: str, path: str) -> list[str]:
    """Return the text of each tag `tag` of a package.xml."""
    from goalwire import xml_tree

    try:
        root = xml_tree.read(xml)
    except xml_tree.XmlError as error:
        raise CommandError(Outcome.FAILED, f'{path} is not well-formed XML: {error}') from error
    return [' '.join(element.text.split()) for element in root.walk() if element.tag == tag]


NOUN = Noun(
    'pkg',
    SUMMARY,
    (
        Verb(
            'executables',
            'Output a list of package specific executables',
            _executables,
            _of_package,
        ),
        Verb('list', 'Output a list of available packages', _list),
        Verb('prefix', 'Output the prefix path of a package', _prefix, _prefix_arguments),
        Verb('xml', 'Output the XML of the package manifest or a specific tag', _xml, _xml_arguments),
    ),
)
