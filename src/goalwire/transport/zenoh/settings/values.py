"""A configuration as JSON values, and access to a setting by its path."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

Json: TypeAlias = 'dict[str, Json] | list[Json] | str | int | float | bool | None'
Settings: TypeAlias = dict[str, Json]


class Configuration(NamedTuple):
    """The settings with which one session is opened."""

    values: Settings
    origin: str = ''
    """The variable and the file that the settings come from; empty for the built-in settings."""

    def at(self, path: str) -> Json:
        """Return one value; None if it is not set."""
        return value_at(self.values, path)

    def set(self, path: str, value: Json) -> None:
        """Set one value, and leave all others as they are."""
        *parents, name = path.split('/')
        within = self.values
        for each in parents:
            inner = within.get(each)
            if not isinstance(inner, dict):
                inner = within[each] = {}
            within = inner
        within[name] = value


def value_at(values: Json, path: str) -> Json:
    """Return the value at a path; None if there is none."""
    for name in path.split('/'):
        values = values.get(name) if isinstance(values, dict) else None
    return values
