"""The five keys of an action, and messages packed by hand, as rmw_zenoh's documents describe them.

Bodies are CDR, little endian, behind four bytes of encapsulation.
"""

import json
import os
import struct
import time
from typing import Any

import zenoh

DOMAIN = os.environ['ROS_DOMAIN_ID']
HEADER = bytes([0, 1, 0, 0])
ACTION = 'example_interfaces::action::dds_::Fibonacci'
GID = bytes(range(16))


def keys(hashes: dict[str, str]) -> dict[str, str]:
    """Return what goes on the wire for each part of the action /fibonacci."""
    types = {
        'send_goal': f'{ACTION}_SendGoal_',
        'get_result': f'{ACTION}_GetResult_',
        'cancel_goal': 'action_msgs::srv::dds_::CancelGoal_',
        'feedback': f'{ACTION}_FeedbackMessage_',
        'status': 'action_msgs::msg::dds_::GoalStatusArray_',
    }
    return {part: f'fibonacci/_action/{part}/{name}/{hashes[part]}' for part, name in types.items()}


def connect() -> zenoh.Session:
    """Open a session as a stock rmw_zenoh node would: a peer that meets others at the router."""
    config = zenoh.Config()
    config.insert_json5('scouting/multicast/enabled', 'false')
    config.insert_json5('timestamping/enabled', 'true')
    router = f'tcp/127.0.0.1:{os.environ["GOALWIRE_ROUTER_PORT"]}'
    config.insert_json5('connect/endpoints', json.dumps([router]))
    return zenoh.open(config)


def direct(function: Any) -> Any:
    """Have zenoh call a function on its own thread."""
    return zenoh.handlers.Callback(function, indirect=False)


def attachment(sequence: int, gid: bytes = GID) -> bytes:
    """Return sequence, time and sender."""
    return struct.pack('<qqB', sequence, time.time_ns(), 16) + gid


def numbers(values: list[int]) -> bytes:
    """Return an int32 sequence."""
    return struct.pack(f'<I{len(values)}i', len(values), *values)


def read_numbers(body: bytes) -> list[int]:
    """Read an int32 sequence that ends the message."""
    (size,) = struct.unpack_from('<I', body)
    return list(struct.unpack_from(f'<{size}i', body, 4))
