"""An action server made of plain zenoh, which takes a step every 20 ms. Argument: hashes as JSON."""

import json
import struct
import sys
import threading
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from raw_action import (  # type: ignore[import-not-found]
    DOMAIN,
    HEADER,
    attachment,
    connect,
    direct,
    keys,
    numbers,
)

EXECUTING, SUCCEEDED, CANCELED = 2, 4, 5
KEYS = keys(json.loads(sys.argv[1]))
session = connect()


def show(number: int, kind: str, part: str, qos: str) -> Any:
    """Declare a liveliness token, by which clients find this server."""
    _, _, _, type_name, type_hash = KEYS[part].split('/')
    head = f'@ros2_lv/{DOMAIN}/{session.zid()}/0/{number}/{kind}/%/%/raw_server'
    return session.liveliness().declare_token(
        f'{head}/%fibonacci%_action%{part}/{type_name}/{type_hash}/{qos}'
    )


@dataclass
class Goal:
    name: bytes
    order: int
    status: int = EXECUTING
    sequence: list[int] = field(default_factory=lambda: [0, 1])
    cancel: threading.Event = field(default_factory=threading.Event)
    ended: threading.Event = field(default_factory=threading.Event)


goals: dict[bytes, Goal] = {}
feedback = session.declare_publisher(f'{DOMAIN}/{KEYS["feedback"]}')
number = count(1).__next__


def reply(query: Any, part: str, body: bytes) -> None:
    request = query.attachment.to_bytes()
    (sequence,) = struct.unpack_from('<q', request)
    query.reply(f'{DOMAIN}/{KEYS[part]}', HEADER + body, attachment=attachment(sequence, request[17:]))
    query.drop()


def execute(goal: Goal) -> None:
    while len(goal.sequence) <= goal.order and not goal.cancel.wait(0.02):
        goal.sequence.append(min(sum(goal.sequence[-2:]), 2**31 - 1))
        body = HEADER + goal.name + numbers(goal.sequence)
        feedback.put(body, attachment=attachment(number()))
    goal.status = CANCELED if goal.cancel.is_set() else SUCCEEDED
    goal.ended.set()


def on_send_goal(query: Any) -> None:
    body = query.payload.to_bytes()[4:]
    name, (order,) = body[:16], struct.unpack_from('<i', body, 16)
    accepted = order > 0
    if accepted:
        goals[name] = Goal(name, order)
        threading.Thread(target=execute, args=(goals[name],), daemon=True).start()
    reply(query, 'send_goal', struct.pack('<B3xiI', accepted, 0, 0))


def on_get_result(query: Any) -> None:
    goal = goals[query.payload.to_bytes()[4:20]]

    def answer() -> None:
        goal.ended.wait()
        reply(query, 'get_result', struct.pack('<b3x', goal.status) + numbers(goal.sequence))

    threading.Thread(target=answer, daemon=True).start()


def on_cancel_goal(query: Any) -> None:
    name = query.payload.to_bytes()[4:20]
    goals[name].cancel.set()
    reply(query, 'cancel_goal', struct.pack('<b3xI', 0, 1) + name + bytes(8))


handlers = {'send_goal': on_send_goal, 'get_result': on_get_result, 'cancel_goal': on_cancel_goal}
declared: list[Any] = [
    session.declare_queryable(f'{DOMAIN}/{KEYS[part]}', direct(handler), complete=True)
    for part, handler in handlers.items()
]
declared.append(
    session.liveliness().declare_token(f'@ros2_lv/{DOMAIN}/{session.zid()}/0/0/NN/%/%/raw_server')
)
declared += [show(each, 'SS', part, '::,10:,:,:,,') for each, part in enumerate(handlers, 1)]
declared += [show(4, 'MP', 'feedback', '::,10:,:,:,,'), show(5, 'MP', 'status', ':1:,1:,:,:,,')]
print('ready', flush=True)
threading.Event().wait()
