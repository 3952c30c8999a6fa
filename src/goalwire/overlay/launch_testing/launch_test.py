"""launch_testing.launch_test: the command `launch_test FILE`."""

from __future__ import annotations

import importlib.util
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from types import ModuleType

from launch_testing.junitxml import unittestResultsToXml
from launch_testing.loader import ENTRY, LoadTestsFromPythonModule
from launch_testing.test_runner import LaunchTestRunner

__all__ = ['add_arguments', 'main', 'run']


def add_arguments(parser: ArgumentParser) -> None:
    """Add the command's arguments to a parser."""
    parser.add_argument('launch_test_file', help='Path to the launch test')
    parser.add_argument('--package-name', help='Name of the package of the test, for reports')
    parser.add_argument('-v', '--verbose', action='store_true', help='Show what the launch does')
    parser.add_argument(
        '-s', '--show-args', '--show-arguments', action='store_true', help='Show arguments of the test alone'
    )
    parser.add_argument('launch_arguments', nargs='*', help='NAME:=VALUE; the last one of a name wins')
    parser.add_argument('--junit-xml', dest='xmlpath', help='File that a report is written to')


def run(
    parser: ArgumentParser, args: Namespace, test_runner_cls: type[LaunchTestRunner] = LaunchTestRunner
) -> int:
    """Run the tests of a file; return 0 if all passed, else 1. End the program if there is no such file."""
    file = Path(args.launch_test_file).resolve()
    if not file.is_file():
        parser.error(f"Test file '{args.launch_test_file}' does not exist")
    package = args.package_name or file.stem
    module = load_file(package, file)
    if not hasattr(module, ENTRY):
        parser.error(f"Test file '{args.launch_test_file}' has no function {ENTRY}")
    name = f'{package}.{file.stem}'
    runs = LoadTestsFromPythonModule(module, name=f'{name}.launch_tests')
    runner = test_runner_cls(runs, args.launch_arguments, args.verbose)
    runner.validate()
    if args.show_args:
        arguments = runs[0].get_launch_description().get_launch_arguments()
        print('\n'.join(f'{each.name}: {each.description}' for each in arguments) or 'No arguments.')
        return 0
    results = runner.run()
    if args.xmlpath:
        report = unittestResultsToXml(name=name, test_results=results)
        report.write(args.xmlpath, encoding='utf-8', xml_declaration=True)
    return 0 if all(result.wasSuccessful() for result in results.values()) else 1


def load_file(name: str, file: Path) -> ModuleType:
    """Import a test file, and return its module."""
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise RuntimeError(f"'{file}' is not a Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def main() -> int:
    """Run the command."""
    parser = ArgumentParser('launch_test', description='Launch integration testing tool.')
    add_arguments(parser)
    args = parser.parse_intermixed_args()
    try:
        return run(parser, args)
    except Exception as error:
        print(f'launch_test: {error}', file=sys.stderr)
        return 1
