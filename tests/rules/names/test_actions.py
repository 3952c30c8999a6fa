from __future__ import annotations

from goalwire.rules.names import ActionNames, is_hidden_name


def test_an_action_speaks_under_five_hidden_names() -> None:
    names = ActionNames('/ns/fibonacci')
    spoken = [names.send_goal, names.cancel_goal, names.get_result, names.feedback, names.status]
    assert [name.rpartition('/')[2] for name in spoken] == [
        'send_goal',
        'cancel_goal',
        'get_result',
        'feedback',
        'status',
    ]
    assert all(name.startswith('/ns/fibonacci/_action/') and is_hidden_name(name) for name in spoken)
