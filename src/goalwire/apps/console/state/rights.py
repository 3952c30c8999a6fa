"""The rights of a page's visitor: the console's options must allow it, and then the policy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from time import monotonic

from goalwire.apps.console.settings import Settings
from goalwire.errors import NotAllowedError
from goalwire.logging import RcutilsLogger
from goalwire.observe.goals import Goal
from goalwire.security.needs import Permission, permission_to_offer, permission_to_use
from goalwire.security.policy import Decision, Verb
from goalwire.security.sign_in.signed_in import SignedIn

_SENDING = (Verb.PUBLISH, Verb.CALL, Verb.SERVE, Verb.SEND, Verb.CANCEL, Verb.SET)
"""The verbs that send something: the console's options --read-only and --allow limit these alone."""
_ONLY_STOPS = ('cancel',)
"""Commands after which no step of a mission begins: who may use the emergency stop may give them."""
_AGAIN_S = 10.0
"""Equal lines about a visitor are logged once in this many seconds: sliders publish ten times a second."""


class Rights:
    """The rights of a visitor. If nobody signs in, only the options of the console count."""

    def __init__(self, settings: Settings, logger: RcutilsLogger, visitor: SignedIn | None = None) -> None:
        self._settings = settings
        self._logger = logger
        self._visitor = visitor
        self._told: tuple[str, float] = ('', 0.0)

    @property
    def who(self) -> str:
        """The name of the visitor; '' if this console knows no names."""
        return '' if self._visitor is None else self._visitor.name

    def problem(self) -> str:
        """Return why the visitor must sign in again; '' if all is well."""
        return '' if self._visitor is None else self._visitor.problem()

    # -- questions about permissions -------------------------------------------------------------------------

    def why_not(self, verb: Verb, name: str) -> str:
        """Return why the visitor may not do something, as a sentence; '' if it may."""
        if verb in _SENDING and not self._settings.may_send(name):
            return _reason(self._settings, name)
        return self._why_not(Permission((verb,), name))

    def may(self, verb: Verb, name: str) -> bool:
        """Return whether the visitor may do something."""
        return not self.why_not(verb, name)

    def why_not_send(self, kind: str, name: str) -> str:
        """Return why the visitor may not send to a 'service', 'action' or 'topic'; '' if it may."""
        if not self._settings.may_send(name):
            return _reason(self._settings, name)
        return self._why_not(_to_send(kind, name))

    def may_see(self, kind: str, name: str) -> bool:
        """Return whether the visitor may see that there is a topic, service, action or node of that name."""
        if self._visitor is None:
            return True
        seen = name.partition('/_action/')[0]
        return self.may(Verb.INTROSPECT, seen) or (kind != 'node' and not self._why_not(_to_look(kind, name)))

    def may_look_at_goals(self, action: str) -> bool:
        """Return whether the visitor may see the goals of an action."""
        return not self._why_not(_to_look('action', action))

    def of_seen_actions(self, goals: Iterable[Goal]) -> list[Goal]:
        """Return the goals of actions that the visitor may watch."""
        return [goal for goal in goals if self.may_look_at_goals(goal.action)]

    def why_not_watch(self, robot: str) -> str:
        """Return why the visitor may not see how a robot moves; '' if it may. `robot` is a namespace."""
        topics = ('/tf', f'{robot}/joint_states')
        return next(filter(None, (self.why_not(Verb.SUBSCRIBE, topic) for topic in topics)), '')

    def why_not_record(self) -> str:
        """Return why the visitor may not record; '' if it may.

        A bag may take every topic, so recording needs `subscribe = ["/**"]` in the policy.
        """
        if self._settings.read_only:
            return 'this console is read-only (--read-only): it does not record'
        return self.why_not(Verb.SUBSCRIBE, '/**')

    def why_not_stop(self) -> str:
        """Return why the visitor may not use the emergency stop; '' if it may.

        The console's options do not limit the emergency stop.
        """
        return '' if self._visitor is None else self._visitor.why_not_stop()

    def why_not_command(self, mission: str, word: str) -> str:
        """Return why the visitor may not give the command `word` to a mission of that name; '' if it may."""
        if not self._settings.may_send(mission):
            return _reason(self._settings, mission)
        if self._visitor is None:
            return ''
        return self._visitor.why_not_stop() if word in _ONLY_STOPS else self._visitor.why_not_missions()

    def _why_not(self, permission: Permission) -> str:
        return '' if self._visitor is None else self._visitor.why_not(permission)

    # -- checks before something is done ---------------------------------------------------------------------

    def check_to_look(self, kind: str, name: str) -> None:
        """Raise NotAllowedError if the visitor may not see a topic's messages, or an action's goals."""
        if self._visitor is not None:
            self._visitor.check_to_look(_to_look(kind, name))

    def check_to_read(self, node: str) -> None:
        """Raise NotAllowedError if the visitor may not read a node's parameters."""
        if self._visitor is not None:
            self._visitor.check_to_look(Permission((Verb.READ,), node))

    def check_to_send(self, kind: str, name: str, what: str = '') -> None:
        """Raise NotAllowedError if the visitor may not send to a 'service', 'action' or 'topic'.

        If the visitor may, the sending is logged; `what` describes the message in one line.
        """
        self._check(_to_send(kind, name), name, what)

    def check(self, verb: Verb, name: str, what: str = '') -> None:
        """Raise NotAllowedError if the visitor may not CANCEL or SET (`verb`) a name; else log the act."""
        self._check(Permission((verb,), name), name, what)

    def _check(self, permission: Permission, name: str, what: str) -> None:
        try:
            self._settings.check_may_send(name)
        except NotAllowedError as error:
            if self._visitor is not None:
                self._visitor.note(permission, Decision(False, str(error)), what)
            raise
        if self._visitor is not None:
            self._visitor.check_to_send(permission, what)
            self._tell(f'{permission.verbs[0].value} {permission.name}')

    def check_to_record(self) -> None:
        """Raise NotAllowedError if the visitor may not begin or end a recording."""
        reason = self.why_not_record()
        if reason:
            raise NotAllowedError(reason)

    def check_to_stop(self, names: Sequence[str]) -> None:
        """Raise NotAllowedError if the visitor may not use the emergency stops of these names."""
        if self._settings.read_only:
            self._settings.check_may_send('')
        if self._visitor is not None:
            self._visitor.check_to_stop(names)
            self._tell(f'stop {", ".join(names)}')

    def check_to_command(self, mission: str, id_: str, verb: str, word: str) -> None:
        """Raise NotAllowedError if the visitor may not give the command `word`; else log the command.

        `mission` and `id_` are the name and the id of the mission; `verb` is that of the command.
        """
        title = f'mission {mission} {id_}'
        what = '' if word == verb else word
        try:
            self._settings.check_may_send(mission)
        except NotAllowedError as error:
            if self._visitor is not None:
                self._visitor.note_mission(title, verb, Decision(False, str(error)), what)
            raise
        if self._visitor is None:
            return
        if word in _ONLY_STOPS:
            self._visitor.check_to_stop([title], verb)
        else:
            self._visitor.check_to_command(title, verb, what)
        self._tell(f'{verb} {title}' + (f': {what}' if what else ''))

    def note(self, act: str, name: str, text: str) -> None:
        """Put into the log and the audit log what the visitor has done."""
        if self._visitor is not None:
            self._visitor.note_done(act, name, text)
            self._tell(f'{act} {name}')

    def _tell(self, text: str) -> None:
        """Log what the visitor does: on /rosout everybody sees who does what."""
        told, at = self._told
        if told != text or monotonic() - at >= _AGAIN_S:
            self._told = text, monotonic()
            self._logger.info(f'{self.who}: {text}')


def _reason(settings: Settings, name: str) -> str:
    """Return why the options do not let the console send to a name."""
    try:
        settings.check_may_send(name)
    except NotAllowedError as error:
        return str(error)
    return ''


def _to_send(kind: str, name: str) -> Permission:
    if kind == 'action':
        return Permission((Verb.SEND,), name)
    if kind == 'service':
        return permission_to_use(name, is_service=True)
    return permission_to_offer(name, is_service=False)


def _to_look(kind: str, name: str) -> Permission:
    if kind == 'action':
        return Permission((Verb.WATCH, Verb.SEND), name)
    return permission_to_use(name, is_service=kind == 'service')
