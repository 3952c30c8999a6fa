"""Reads a policy.toml. Errors have line and column, and say what to write instead.

mode = "enforce"
[everyone]            # grants of each identity
publish = ["/rosout"]
[roles.operator]      # grants of those who have the role
namespace = "/robot1" # names that do not begin with a slash are below it
domains = [0, 7]      # where the role holds; all domains if it is left out
call = ["/reset", "arm/*"]
stop = false          # no emergency stop of a console; only to forbid it
missions = true       # answer, resume and undo missions in a console; only to allow it
[moving]              # what the audit log has also if it is allowed; each verb has a default
publish = ["/**/cmd_vel"]
[identities]
alice = ["operator"]
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple, NoReturn

from goalwire.errors import PolicyError, SecurityError, did_you_mean, with_advice
from goalwire.files import read_regular
from goalwire.patterns import Pattern
from goalwire.security.policy import MISSIONS, MODES, MOVING, STOP, Grant, MissionGrant, Policy, Verb
from goalwire.security.toml_places import Place, find_places

_VERBS = {verb.value: verb for verb in Verb}
_TABLES = ('mode', 'everyone', 'roles', 'moving', 'identities')
_SETTINGS = ('namespace', 'domains', STOP, MISSIONS)
_SWITCHES = {
    STOP: (False, 'leave it out, since everybody may stop; or write stop = false to forbid it'),
    MISSIONS: (True, 'leave it out, since nobody may without it; or write missions = true to allow it'),
}
"""The settings that have one valid value: that value, and the advice if the file has another value."""
_NAME = Pattern(r'(?:/(?:\*\*|[A-Za-z0-9_~*]+))+\Z')
_TOML_PLACE = Pattern(r' \(at (?:line (\d+), column (\d+)|end of document)\)\Z')
_LARGEST_DOMAIN = 232
LARGEST_POLICY = 1 << 20
"""The largest size of a policy, in bytes."""


def read_policy(text: str, title: str = 'policy.toml') -> Policy:
    """Read a policy. Raises PolicyError, which names `title`, line and column."""
    return _Reader(text, title).read()


def load_policy(path: Path) -> Policy:
    """Read a policy from its file. Raises SecurityError."""
    try:
        text = read_regular(os.fspath(path), LARGEST_POLICY).decode()
    except OSError as error:
        raise SecurityError(f"'{path}' cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise SecurityError(f"'{path}' is not UTF-8: {error.reason} at byte {error.start}") from None
    return read_policy(text, os.fspath(path))


class _Switch(NamedTuple):
    """A table of policy.toml that forbids the emergency stop, or allows commands to missions."""

    path: tuple[str, ...]
    """The table: ('everyone',), or ('roles', NAME)."""
    line: int
    domains: tuple[int, ...]

    def concerns(self, having: object) -> bool:
        """Return whether the table applies to an identity with these roles."""
        return len(self.path) == 1 or (isinstance(having, list) and self.path[-1] in having)


class _Reader:
    """Parses the text of one policy.toml."""

    def __init__(self, text: str, title: str) -> None:
        self._title = title
        try:
            self._content = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            found = _TOML_PLACE.search(str(error))
            if found and found[1]:
                place = Place(int(found[1]), int(found[2]))
            else:  # no place is given if the text ends too early
                place = Place(text.count('\n') + 1, len(text) - text.rfind('\n'))
            self._places: dict[tuple[str | int, ...], Place] = {(): place}
            self._refuse((), f'this is not TOML: {_TOML_PLACE.sub("", str(error))}', 'see: toml.io')
        self._places = find_places(text)

    def _place(self, path: tuple[str | int, ...]) -> Place:
        """Return the position of an item, or of the table that holds it."""
        while path and path not in self._places:
            path = path[:-1]
        return self._places.get(path, Place(1, 1))

    def _refuse(self, path: tuple[str | int, ...], problem: str, advice: str) -> NoReturn:
        raise PolicyError(self._title, self._place(path), with_advice(problem, advice))

    def _refuse_name(self, path: tuple[str | int, ...], what: str, known: tuple[str, ...]) -> NoReturn:
        """Refuse a word that is not among the known ones."""
        name = str(path[-1])
        near = did_you_mean(get_close_matches(name, known, 3, 0.6))
        self._refuse(path, f"'{name}' is not {what}", near or f'write one of {", ".join(known)}')

    def read(self) -> Policy:
        """Read the file and return the policy."""
        content = self._content
        for name in content:
            if name not in _TABLES:
                self._refuse_name((name,), 'known here', _TABLES)
        mode = content.get('mode', 'enforce')
        if mode not in MODES:
            self._refuse(('mode',), f'mode is {mode!r}', 'write mode = "enforce" or mode = "audit"')
        everyone = tuple(self._grants(('everyone',), 'everyone', self._table(('everyone',), content)))
        all_roles = self._table(('roles',), content)
        roles = {
            name: tuple(self._grants(('roles', name), name, self._table(('roles', name), all_roles)))
            for name in all_roles
        }
        forbids_stop, allows_missions = list(self._switches(STOP)), list(self._switches(MISSIONS))
        identities = self._table(('identities',), content)
        return Policy(
            str(mode),
            {name: (*everyone, *self._of_roles(name, identities[name], roles)) for name in identities},
            self._title,
            {name: self._place(('identities', name)).line for name in identities},
            self._moving(self._table(('moving',), content)),
            {
                name: (each.path[-1], each.line)
                for name, having in identities.items()
                for each in forbids_stop
                if each.concerns(having)
            },
            {
                name: tuple(
                    MissionGrant(each.path[-1], each.line, each.domains)
                    for each in allows_missions
                    if each.concerns(having)
                )
                for name, having in identities.items()
            },
        )

    def _moving(self, table: dict[str, object]) -> tuple[Grant, ...]:
        """Return the acts that move a robot: a verb that the table lacks keeps its default."""
        for word in (STOP, MISSIONS):
            if word in table:
                self._refuse(('moving', word), f'{word} is not a verb', 'write it into [everyone] or a role')
        given = tuple(self._grants(('moving',), 'moving', table))
        return given + tuple(each for each in MOVING if each.verb.value not in table)

    def _switches(self, word: str) -> Iterator[_Switch]:
        """Yield the tables that contain the setting `word`, which is STOP or MISSIONS."""
        value, advice = _SWITCHES[word]
        roles = self._table(('roles',), self._content)
        tables: list[tuple[tuple[str, ...], object]] = [(('everyone',), self._content.get('everyone'))]
        tables += [(('roles', name), roles[name]) for name in roles]
        for path, table in tables:
            if not isinstance(table, dict) or word not in table:
                continue
            here = (*path, word)
            if table[word] is not value:
                self._refuse(here, f'{word} is {table[word]!r}', advice)
            domains = self._domains(path, table.get('domains', []))
            yield _Switch(path, self._place(here).line, domains)

    def _table(self, path: tuple[str, ...], parent: dict[str, object]) -> dict[str, object]:
        found = parent.get(path[-1], {})
        if not isinstance(found, dict):
            self._refuse(path, f'{path[-1]} is not a table', f'write [{".".join(path)}] in a line of its own')
        return found

    def _of_roles(self, name: str, wanted: object, roles: dict[str, tuple[Grant, ...]]) -> Iterator[Grant]:
        path = ('identities', name)
        for at, role in enumerate(self._texts(path, wanted, '["operator"]')):
            if role not in roles:
                near = did_you_mean(get_close_matches(role, roles, 3, 0.6))
                advice = near or f'add [roles.{role}], or take one of {", ".join(roles)}'
                self._refuse((*path, at), f"there is no role '{role}'", advice)
            yield from roles[role]

    def _texts(self, path: tuple[str, ...], found: object, example: str) -> list[str]:
        if not isinstance(found, list):
            self._refuse(path, f'{path[-1]} takes a list of texts, not {found!r}', f'write {example}')
        for at, each in enumerate(found):
            if not isinstance(each, str):
                self._refuse((*path, at), f'{each!r} is not a text', f'write {example}')
        return found

    def _grants(self, path: tuple[str, ...], role: str, table: dict[str, object]) -> Iterator[Grant]:
        namespace = self._namespace(path, table.get('namespace', ''))
        domains = self._domains(path, table.get('domains', []))
        for word, names in table.items():
            if word in _SETTINGS:
                continue
            verb = _VERBS.get(word)
            if verb is None:
                self._refuse_name((*path, word), 'a verb', (*_VERBS, *_SETTINGS))
            for at, name in enumerate(self._texts((*path, word), names, f'{word} = ["/name"]')):
                here: tuple[str | int, ...] = (*path, word, at)
                full = name if name.startswith('/') else f'{namespace}/{name}'
                if not name.startswith('/') and not namespace:
                    self._refuse(here, f"'{name}' has no slash at its beginning", f"write '/{name}'")
                self._check_pattern(here, name, full)
                yield Grant(verb, full, role, self._place(here).line, domains)

    def _check_pattern(self, path: tuple[str | int, ...], name: str, full: str) -> None:
        if not _NAME.match(full) or any('**' in chunk and chunk != '**' for chunk in full.split('/')):
            self._refuse(
                path,
                f"'{name}' is not a pattern of names",
                "write letters, digits and '_' between slashes, '*' for any of them, '/**' for any names",
            )

    def _namespace(self, path: tuple[str, ...], found: object) -> str:
        if not isinstance(found, str) or (found and (not _NAME.match(found) or '*' in found)):
            self._refuse(
                (*path, 'namespace'), f'{found!r} is not a namespace', 'write one like namespace = "/robot1"'
            )
        return found

    def _domains(self, path: tuple[str, ...], found: object) -> tuple[int, ...]:
        wanted = found if isinstance(found, list) else [found]
        for each in wanted:
            if type(each) is not int or not 0 <= each <= _LARGEST_DOMAIN:
                self._refuse(
                    (*path, 'domains'),
                    f'{each!r} is not a domain',
                    f'write numbers from 0 to {_LARGEST_DOMAIN}: domains = [0, 7]',
                )
        return tuple(wanted)
