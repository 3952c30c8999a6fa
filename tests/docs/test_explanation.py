"""The drawings and tables of the explanations are those of the code."""

from __future__ import annotations

from helpers.markdown import DOCS, blocks

from goalwire.rules.goals.table import TABLE, GoalStatus
from goalwire.rules.qos import QoS
from goalwire.transport.contract import Endpoint, EndpointKind, NodeName
from goalwire.transport.zenoh.tokens import data_key, encode_endpoint

EXPLANATION = DOCS / 'explanation'


def test_the_drawing_of_a_goals_life_is_the_table() -> None:
    arrows = [f'[*] --> {GoalStatus.ACCEPTED.name}']
    for status, events in TABLE.items():
        arrows += [f'{status.name} --> {after.name}: {event.name}' for event, after in events.items()]
        if not events:
            arrows.append(f'{status.name} --> [*]')
    [drawing] = [block for block in blocks(EXPLANATION / 'actions.md') if block.language == 'mermaid']
    drawn = [line.strip() for line in drawing.text.splitlines()[1:]]
    assert sorted(drawn) == sorted(arrows)


def test_the_key_and_the_token_of_the_page_are_those_of_the_code() -> None:
    shown = [block.text.strip() for block in blocks(EXPLANATION / 'transport.md') if block.language == 'text']
    shown_key, shown_token = shown
    type_name, type_hash = 'std_msgs/msg/String', shown_key.rpartition('/')[2]
    assert shown_key == data_key(0, '/chatter', type_name, type_hash)
    endpoint = Endpoint(EndpointKind.PUBLISHER, '/chatter', type_name, 'RIHS01_…', QoS(depth=10))
    token = encode_endpoint(0, '<session>', 0, 2, NodeName('talker'), endpoint)
    assert shown_token == token
