"""Decides what a client of a bridge may do: by the options of the bridge, then by the policy."""

from __future__ import annotations

import re
from fnmatch import translate

from goalwire.errors import NotAllowedError
from goalwire.records import record
from goalwire.security.needs import READING, SETTING, Permission, permission_to_offer, permission_to_use
from goalwire.security.policy import Verb
from goalwire.security.sign_in.signed_in import SignedIn

REGULAR = 're:'
"""The prefix of a pattern that is a regular expression. Other patterns are globs such as '/arm/*'."""
_HIDDEN = '/_action/'
_EVENTS_OF_PARAMETERS = 'parameter_events'
_SERVICE_EVENT = '/_service_event'


@record
class Patterns:
    """An allow list; an empty one allows every name."""

    flag: str
    """The command-line option that sets this allow list, for error texts."""
    patterns: tuple[str, ...] = ()

    def allow(self, name: str) -> bool:
        """Return whether a name is allowed."""
        return not self.patterns or any(_expression(each).fullmatch(name) for each in self.patterns)

    def check(self, name: str) -> None:
        """Raise NotAllowedError for a name that is not allowed."""
        if not self.allow(name):
            raise NotAllowedError(f"this bridge does not give access to '{name}': see its option {self.flag}")


def _expression(pattern: str) -> re.Pattern[str]:
    """Return the compiled pattern; the module `re` keeps it. Raises re.error."""
    if pattern.startswith(REGULAR):
        return re.compile(pattern.removeprefix(REGULAR))
    return re.compile(translate(pattern))


def check_pattern(pattern: str) -> None:
    """Raise ValueError for a pattern that is not a regular expression."""
    try:
        _expression(pattern)
    except re.error as error:
        raise ValueError(f"'{pattern}' is not a regular expression: {error}") from None


def _tells_of_parameters(topic: str) -> bool:
    """Return True if a topic reveals parameters: by their events, or by events of parameter services."""
    name = topic.removesuffix(_SERVICE_EVENT).rsplit('/', 1)[-1]
    return name == _EVENTS_OF_PARAMETERS or (topic.endswith(_SERVICE_EVENT) and name in {*READING, *SETTING})


@record
class Permissions:
    """The names that clients may use, for each kind of use. An action's permission includes its parts."""

    publish: Patterns = Patterns('--publish')
    subscribe: Patterns = Patterns('--subscribe')
    services: Patterns = Patterns('--services')
    actions: Patterns = Patterns('--actions')
    parameters: Patterns = Patterns('--parameters')
    """Patterns for parameters, matched with '/node:parameter'."""
    read_only: bool = False
    client: SignedIn | None = None
    """The signed-in client, whose every act the policy must allow, too; None if clients do not sign in."""

    def check_publish(self, topic: str) -> None:
        """Raise NotAllowedError if the client may not publish on a topic."""
        self._check_change()
        self._check(topic, self.publish)
        self._ask(permission_to_offer(topic, is_service=False))

    def check_message(self, topic: str) -> None:
        """Raise NotAllowedError if the policy forbids the client to publish a message; else log the message.

        `check_publish` has already applied the bridge's options.
        """
        if self.client is not None:
            self.client.check_to_send(permission_to_offer(topic, is_service=False))

    def check_subscribe(self, topic: str) -> None:
        """Raise NotAllowedError if clients may not subscribe to a topic.

        If there is an allow list of parameters, topics that reveal any parameter are refused, too.
        """
        if self.parameters.patterns and _tells_of_parameters(topic):
            raise self._explain_limit(topic)
        self._check(topic, self.subscribe)
        self._ask(permission_to_use(topic, is_service=False))

    def check_call(self, service: str) -> None:
        """Raise NotAllowedError if the client may not call a service; else log the call."""
        self._check_service(service)
        if self.client is not None:
            self.client.check_to_send(permission_to_use(service, is_service=True))

    def check_serve(self, service: str) -> None:
        """Raise NotAllowedError if the client may not serve a service."""
        self._check_service(service)
        self._ask(permission_to_offer(service, is_service=True))

    def _check_service(self, service: str) -> None:
        """Raise NotAllowedError if the bridge's options do not allow the service.

        If there is an allow list of parameters, the parameter services of nodes are refused, because they
        would bypass it.
        """
        self._check_change()
        if self.parameters.patterns and service.rsplit('/', 1)[-1] in {*READING, *SETTING}:
            raise self._explain_limit(service)
        self._check(service, self.services)

    def check_goal(self, action: str) -> None:
        """Raise NotAllowedError if the client may not send goals to an action; else log the goal."""
        self._check_change()
        self.actions.check(action)
        if self.client is not None:
            self.client.check_to_send(Permission((Verb.SEND,), action))

    def check_serve_action(self, action: str) -> None:
        """Raise NotAllowedError if the client may not serve an action."""
        self._check_change()
        self.actions.check(action)
        self._ask(Permission((Verb.SERVE,), action))

    def check_parameter(self, name: str, *, to_set: bool) -> None:
        """Raise NotAllowedError if clients may not read, or not set, '/node:parameter'."""
        if to_set:
            self._check_change()
        self.parameters.check(name)
        node = name.partition(':')[0]
        if to_set and self.client is not None:
            self.client.check_to_send(Permission((Verb.SET,), node), name)
        elif not to_set:
            self._ask(Permission((Verb.READ,), node))

    def shows_parameter(self, name: str) -> bool:
        """Return whether the client may know of '/node:parameter'."""
        return self.parameters.allow(name) and self._is_granted(
            Permission((Verb.READ,), name.partition(':')[0])
        )

    def shows_node(self, node: str) -> bool:
        """Return whether the client may know of a node."""
        return self._is_granted(Permission((Verb.INTROSPECT,), node))

    def shows_action(self, action: str) -> bool:
        """Return whether the client may know of an action."""
        return self.actions.allow(action) and self._is_granted(
            Permission((Verb.SEND, Verb.WATCH, Verb.INTROSPECT), action)
        )

    def shows_topic(self, topic: str) -> bool:
        """Return whether the client may know of a topic."""
        if not self._is_granted(permission_to_use(topic, is_service=False)) and not self._is_granted(
            permission_to_offer(topic, is_service=False)
        ):
            return False
        if _HIDDEN in topic:
            return self.actions.allow(topic.partition(_HIDDEN)[0])
        if self.parameters.patterns and _tells_of_parameters(topic):
            return False
        return self.subscribe.allow(topic) or (not self.read_only and self.publish.allow(topic))

    def shows_service(self, service: str) -> bool:
        """Return whether the client may know of a service."""
        if not self._is_granted(permission_to_use(service, is_service=True)):
            return False
        patterns = self.actions if _HIDDEN in service else self.services
        return patterns.allow(service.partition(_HIDDEN)[0])

    def _ask(self, permission: Permission) -> None:
        """Raise NotAllowedError if the policy does not give the client a permission."""
        if self.client is not None:
            self.client.check_to_look(permission)

    def _is_granted(self, permission: Permission) -> bool:
        return self.client is None or not self.client.why_not(permission)

    @staticmethod
    def _explain_limit(name: str) -> NotAllowedError:
        return NotAllowedError(
            f"this bridge does not give access to '{name}', since its parameters are limited "
            '(--parameters): use the operations for parameters'
        )

    def _check(self, name: str, patterns: Patterns) -> None:
        if _HIDDEN in name:
            self.actions.check(name.partition(_HIDDEN)[0])
        else:
            patterns.check(name)

    def _check_change(self) -> None:
        if self.read_only:
            raise NotAllowedError('this bridge is read-only (--read-only): nothing was sent')
