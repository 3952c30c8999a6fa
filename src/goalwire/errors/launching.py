"""Errors of launch files."""

from __future__ import annotations

from collections.abc import Sequence

from goalwire.errors.base import LocalError


class LaunchError(LocalError, RuntimeError):
    """A launch file asks for something that cannot be done. `located` is True if the text begins with file
    and line.
    """

    def __init__(self, text: str = '', *, located: bool = False) -> None:
        super().__init__(text)
        self.located = located


class BadLaunchValueError(LaunchError, TypeError, ValueError):
    """An action or a parameter in a launch file was given a value of another type than it takes."""


class InvalidLaunchFileError(LaunchError):
    """A file is not a launch file, or breaks the rules of its format."""

    def __init__(
        self,
        text: str = '',
        *,
        located: bool = False,
        extension: str = '',
        likely_errors: Sequence[Exception] = (),
    ) -> None:
        """Without `text`, the text is made of `likely_errors`, which reading a file with this `extension` has
        raised.
        """
        if likely_errors and not text:
            reasons = '; '.join(f'{type(error).__name__}: {error}' for error in likely_errors)
            text = f"a file ending with '{extension}' cannot be read as a launch file: {reasons}"
            self.__cause__ = likely_errors[0]
        super().__init__(text or 'the launch file cannot be read', located=located)


class InvalidFrontendLaunchFileError(InvalidLaunchFileError):
    """A launch file in XML or YAML breaks the rules of its format."""


class SubstitutionFailure(LaunchError):
    """A substitution in a launch file has no value."""


class InvalidConditionExpressionError(LaunchError):
    """The value of a condition in a launch file is neither true nor false."""


class NoSuchPackageError(LaunchError):
    """No package has that name."""


class NoLaunchFileError(LaunchError, FileNotFoundError):
    """A package has no launch file of that name, or there is none at that path."""


class BadLaunchArgumentError(LaunchError):
    """A word on the command line of a launch does not have the form `name:=value`."""
