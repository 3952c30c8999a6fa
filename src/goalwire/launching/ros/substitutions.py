"""Substitutions for folders and programs of ROS packages, and for parameters."""

from __future__ import annotations

from typing import Any

from goalwire.errors import SubstitutionFailure
from goalwire.launching import packages
from goalwire.launching.exposure import expose_substitution
from goalwire.launching.model import LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.substitutions import CompoundSubstitution, PathJoinSubstitution
from goalwire.launching.values import perform_text


class FindPackage(CompoundSubstitution):
    """The base of substitutions that look something up in a package."""

    names = ('package',)

    def __init__(self, package: SomeSubstitutions) -> None:
        super().__init__(package)

    @property
    def package(self) -> list[Substitution]:
        return self._parts[0]

    def __truediv__(self, more: SomeSubstitutions) -> PathJoinSubstitution:
        return PathJoinSubstitution([self, more])

    def find(self, package_name: str) -> str:
        raise NotImplementedError

    def perform(self, context: LaunchContext) -> str:
        return self.find(self._text(context, 0))


@expose_substitution('find-pkg-prefix')
class FindPackagePrefix(FindPackage):
    """The folder that a package is installed in."""

    def find(self, package_name: str) -> str:
        return packages.prefix(package_name)


@expose_substitution('find-pkg-share')
class FindPackageShare(FindPackage):
    """The share folder of a package."""

    def find(self, package_name: str) -> str:
        return packages.share(package_name)


@expose_substitution('exec-in-pkg', 'exec-in-package')
class ExecutableInPackage(CompoundSubstitution):
    """The path of a package's program."""

    names = ('executable', 'package')

    def __init__(self, executable: SomeSubstitutions, package: SomeSubstitutions) -> None:
        super().__init__(executable, package)

    @property
    def executable(self) -> list[Substitution]:
        return self._parts[0]

    @property
    def package(self) -> list[Substitution]:
        return self._parts[1]

    def perform(self, context: LaunchContext) -> str:
        return packages.executable(self._text(context, 1), self._text(context, 0))


@expose_substitution('param')
class Parameter(CompoundSubstitution):
    """The value of a parameter that SetParameter has set in this scope."""

    names = ('name', 'default')
    least = 1

    def __init__(self, name: SomeSubstitutions, *, default: SomeSubstitutions | None = None) -> None:
        super().__init__(name)
        self._default = default

    def perform(self, context: LaunchContext) -> str:
        name = self._text(context, 0)
        found: Any = None
        for entry in context.launch_configurations.get('global_params', ()):
            if isinstance(entry, tuple) and entry[0] == name:
                found = entry[1]
        if found is not None:
            return str(found)
        if self._default is not None:
            return perform_text(context, self._default)
        raise SubstitutionFailure(f"no SetParameter has set the parameter '{name}' in this scope")
