"""The outcome of a step, as the journal keeps it: a value, a message in CDR with its type hash, or an error.

A mission that is started again gets the same outcomes as the first time, errors too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire import errors
from goalwire.cdr import codec
from goalwire.cdr.type_hash import type_hash
from goalwire.errors import CallError, GoalFailed, MissionStopped, StepFailed, StepLost
from goalwire.missions.journal_store import LARGEST_VALUE, as_json
from goalwire.records import record
from goalwire.rules.missions.entries import Entry, EntryKind, Json, StepKey
from goalwire.rules.missions.replay import DoesNotFit

if TYPE_CHECKING:
    from collections.abc import Mapping


@record
class Outcome:
    """A value or an error. If the value is a message, `message_type` is its class."""

    value: Any = None
    error: Exception | None = None
    message_type: type | None = None

    def take(self) -> Any:
        """Return the value, or raise the error."""
        if self.error is not None:
            raise self.error
        return self.value


def encode_message(message: Any) -> tuple[dict[str, Json], bytes]:
    """Return a message's facts for the journal, and its CDR. Raises ValueError if it is too large."""
    data = codec.encode(message)
    if len(data) > LARGEST_VALUE:
        raise ValueError(
            f'a message in a journal may have at most {LARGEST_VALUE:,} bytes, not {len(data):,}: '
            'keep it in a file, and send a reference'
        )
    return {'message': type(message).__name__, 'hash': type_hash(type(message))}, data


def decode_message(body: Mapping[str, Json], data: bytes, cls: type) -> Any:
    """Return a message from the journal. Raises DoesNotFit if its type has changed."""
    if body.get('hash') != type_hash(cls):
        raise DoesNotFit(f'{cls.__name__} has another definition than when the journal was written')
    return codec.decode(data, cls)


def make_end_entry(step: int, key: StepKey, outcome: Outcome) -> Entry:
    """Return the entry for the end of a step. Raises TypeError or ValueError for unfit values."""
    body, data = _error_facts(outcome.error) if outcome.error is not None else _value_facts(outcome)
    as_json(body)
    return Entry(EntryKind.ENDED, step, key.facts | body, data)


def _value_facts(outcome: Outcome) -> tuple[dict[str, Json], bytes]:
    if outcome.message_type is None or outcome.value is None:
        return {'value': outcome.value}, b''
    return encode_message(outcome.value)


def _error_facts(error: Exception) -> tuple[dict[str, Json], bytes]:
    facts: dict[str, Json] = {'error': type(error).__name__, 'text': str(error)}
    data = b''
    if isinstance(error, CallError):
        facts |= {'name': error.name, 'peers': list(error.peers), 'waited': error.waited}
    if isinstance(error, GoalFailed) and error.result is not None:
        result, data = encode_message(error.result)
        facts |= result
    if isinstance(error, MissionStopped):
        facts['undo'] = error.undo
    return facts, data


def outcome_of(entry: Entry, message_type: type | None) -> Outcome:
    """Return the outcome that an entry keeps. Raises DoesNotFit if a message's type has changed."""
    body = entry.body
    if 'error' in body:
        return Outcome(error=_error_of(entry, message_type))
    if message_type is None or 'hash' not in body:
        return Outcome(body.get('value'))
    return Outcome(decode_message(body, entry.data, message_type), message_type=message_type)


def _error_of(entry: Entry, message_type: type | None) -> Exception:
    body = entry.body
    kind, text = str(body['error']), str(body['text'])
    if kind == MissionStopped.__name__:
        return MissionStopped(text, undo=bool(body.get('undo')))
    if kind == StepLost.__name__:
        return StepLost(text)
    cls = getattr(errors, kind, None)
    if not (isinstance(cls, type) and issubclass(cls, CallError)):
        return StepFailed(text)
    peers, waited = body.get('peers'), body.get('waited')
    error = cls(
        text,
        name=str(body.get('name', '')),
        peers=[str(each) for each in peers] if isinstance(peers, list) else (),
        waited=waited if isinstance(waited, float) else 0.0,
    )
    if isinstance(error, GoalFailed) and 'hash' in body and message_type is not None:
        error.result = decode_message(body, entry.data, message_type)
    return error
