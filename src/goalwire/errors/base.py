"""The parents of the other errors, and the errors that have no family."""

from __future__ import annotations

from goalwire.errors.wording import peer_text


class GoalwireError(Exception):
    """The base class of all errors that goalwire raises."""

    __module__ = 'goalwire.errors'

    def __init_subclass__(cls) -> None:
        # Programs import every error from the package, so tracebacks and pickles name the package.
        if cls.__module__.startswith('goalwire.errors.'):
            cls.__module__ = 'goalwire.errors'


class LocalError(GoalwireError):
    """The calling program made a mistake."""


class RemoteError(GoalwireError):
    """A peer sent something that breaks the rules; `peer_text` makes the text of the error safe to show."""

    def __init__(self, message: str = '') -> None:
        super().__init__(peer_text(message))


class TransportError(GoalwireError):
    """The wire itself failed, for example because no session could be opened."""


class AddressTakenError(TransportError):
    """A session cannot listen at its address, since another program does."""


class SecurityError(GoalwireError):
    """A keystore, an identity or a policy cannot be used as asked."""


class PolicyError(SecurityError):
    """A policy.toml breaks its grammar; `line` and `column` count from 1."""

    def __init__(self, title: str, place: tuple[int, int], problem: str) -> None:
        self.line, self.column = place
        super().__init__(f'{title}:{self.line}:{self.column}: {problem}')


class NotAllowedError(LocalError):
    """The console or a bridge does not allow a request, because of its options or because too many are under
    way.
    """


class BagError(GoalwireError):
    """A bag cannot be read, or cannot be written."""


class UnknownSeverityError(LocalError, RuntimeError):
    """No severity of log messages has that name."""


class LoggingOptionError(LocalError, TypeError):
    """A log call has an unknown option, or lacks an option that it needs."""


class LoggerNameError(LocalError, ValueError):
    """A logger was to be made without a name."""


class ChangedCallError(LocalError, ValueError):
    """One log call in the source was used with different names, severities or filters."""
