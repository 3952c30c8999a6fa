"""Which topics the flags mean."""

from __future__ import annotations

import pytest

from goalwire.apps.bag.selection import Names, Selection, action_of, is_hidden, service_of

CHATTER, HIDDEN = '/chatter', '/_hidden/topic'
ADD = '/add/_service_event'
FEEDBACK, STATUS = '/walk/_action/feedback', '/walk/_action/status'
SEND = '/walk/_action/send_goal/_service_event'
ALL = [CHATTER, HIDDEN, ADD, FEEDBACK, STATUS, SEND]
TYPES = {CHATTER: 'std_msgs/msg/String', HIDDEN: 'std_msgs/msg/Int32'}
EVERY = Names(all=True)


def some(*names: str) -> Names:
    return Names(some=frozenset(names))


@pytest.mark.parametrize(
    ('selection', 'wanted'),
    [
        (Selection(), []),
        (Selection(EVERY), [CHATTER]),
        (Selection(EVERY, EVERY, EVERY), [CHATTER, ADD, FEEDBACK, STATUS, SEND]),
        (Selection(EVERY, hidden=True), [CHATTER, HIDDEN]),
        (Selection(some(HIDDEN)), [HIDDEN]),
        (Selection(services=EVERY), [ADD]),
        (Selection(services=some('/add')), [ADD]),
        (Selection(actions=some('/walk')), [FEEDBACK, STATUS, SEND]),
        (Selection(types=frozenset({'std_msgs/msg/String'})), [CHATTER]),
        (Selection(EVERY, types_out=frozenset({'std_msgs/msg/String'})), []),
        (Selection(regex='a'), [CHATTER, ADD, FEEDBACK, STATUS, SEND]),
        (Selection(regex='^/wa'), [FEEDBACK, STATUS, SEND]),
        (Selection(EVERY, EVERY, regex_out='add|chat'), []),
        (Selection(Names(all=True, out=frozenset({CHATTER})), EVERY), [ADD]),
        (Selection(EVERY, Names(all=True, out=frozenset({'/add'}))), [CHATTER]),
        (Selection(regex='.*', actions=Names(out=frozenset({'/walk'}))), [CHATTER, ADD]),
    ],
)
def test_flags_choose_topics(selection: Selection, wanted: list[str]) -> None:
    assert [topic for topic in ALL if selection.wants(topic, TYPES.get(topic, 'x/srv/Y_Event'))] == wanted


def test_parts_of_services_and_actions_are_known() -> None:
    assert [service_of(topic) for topic in ALL] == ['', '', '/add', '', '', '']
    assert [action_of(topic) for topic in ALL] == ['', '', '', '/walk', '/walk', '/walk']
    assert [is_hidden(topic) for topic in ('/a/_b', '/a/b_', '/_a')] == [True, False, True]
