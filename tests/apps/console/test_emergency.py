"""How an emergency stop stands, as a robot's publishers tell it, and whose a name is."""

from __future__ import annotations

from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from std_msgs.msg import Bool

from goalwire.apps.console.state.emergency import REPEATS, SILENT_AFTER, EmergencyState, Standing
from goalwire.apps.console.state.ownership import may_move, may_stop, owner
from goalwire.observe.emergency_stops import (
    BOOL,
    DIAGNOSTIC_STATUS,
    StopService,
    Word,
    says_state,
    stop_services,
    word_of,
)

STATE = '/emergency_stopped'
STATUS = '/emergency_stop_status'


def word(node: str, *, stopped: bool, topic: str = STATE, **more: Any) -> Word:
    return Word(node, topic, stopped, **more)


def heard(*words: tuple[bytes, Word]) -> EmergencyState:
    state = EmergencyState()
    for publisher, said in words:
        state.hear(publisher, said)
    state.keep({(said.topic, publisher) for publisher, said in words})
    return state


def standing(state: EmergencyState) -> Standing:
    return state.standing


# -- what counts ---------------------------------------------------------------------------------------------


def test_stops_are_known_by_name_and_type() -> None:
    found = stop_services(
        [
            ('/estop', ['std_srvs/srv/Trigger']),
            ('/base/emergency_stop', ['std_srvs/srv/SetBool']),
            ('/arm/E_Stop', ['std_srvs/srv/Empty']),
            ('/estop/release', ['std_srvs/srv/Trigger']),
            ('/release_estop', ['std_srvs/srv/Trigger']),
            ('/estop_state', ['example_interfaces/srv/AddTwoInts']),
            ('/lamp', ['std_srvs/srv/SetBool']),
        ]
    )
    assert [stop.name for stop in found] == ['/estop', '/base/emergency_stop', '/arm/E_Stop']
    assert [stop.values for stop in found] == [{}, {'data': True}, {}]


@pytest.mark.parametrize(
    ('topic', 'type_name', 'says'),
    [
        ('/emergency_stopped', BOOL, True),
        ('/alice/estop_active', BOOL, True),
        ('/emergency_stop_status', DIAGNOSTIC_STATUS, True),
        ('/emergency_stop', BOOL, False),  # a button
        ('/emergency_stopped', DIAGNOSTIC_STATUS, False),
        ('/diagnostics_status', DIAGNOSTIC_STATUS, False),
    ],
)
def test_topics_that_say_the_state_are_known_by_name_and_type(topic: str, type_name: str, says: bool) -> None:
    assert says_state(topic, type_name) is says


def test_a_status_has_the_reason_and_who_did_it() -> None:
    values = [KeyValue(key='stopped', value='true'), KeyValue(key='by', value='/pad')]
    status = DiagnosticStatus(level=DiagnosticStatus.ERROR, message='the pad called', values=values)
    assert word_of(status, '/switch', STATUS, is_switch=True) == Word(
        '/switch', STATUS, True, 'the pad called', '/pad', True
    )
    assert word_of(DiagnosticStatus(level=DiagnosticStatus.ERROR), '/s', STATUS, is_switch=False).stopped
    assert not word_of(DiagnosticStatus(message='released'), '/s', STATUS, is_switch=False).stopped
    assert word_of(Bool(data=True), '/s', STATE, is_switch=False) == Word('/s', STATE, True)


def test_a_long_reason_of_a_peer_is_cut() -> None:
    status = DiagnosticStatus(level=DiagnosticStatus.ERROR, message='x' * 10_000)
    assert len(word_of(status, '/s', STATUS, is_switch=False).reason) < 400


# -- how it stands -------------------------------------------------------------------------------------------


def test_a_robot_that_says_nothing_is_untold() -> None:
    state = EmergencyState()
    state.serve([StopService('/estop', 'std_srvs/srv/Trigger')])
    assert (standing(state), state.reason) == (Standing.UNTOLD, '')


def test_one_who_says_stopped_counts_more_than_others_who_do_not() -> None:
    state = heard((b'a', word('/a', stopped=True)), (b'b', word('/b', stopped=False)))
    assert standing(state) is Standing.STOPPED
    assert state.reason == '/a says so on /emergency_stopped'
    state.hear(b'b', word('/b', stopped=False))
    assert standing(state) is Standing.STOPPED
    state.hear(b'a', word('/a', stopped=False))
    assert standing(state) is Standing.RELEASED


def test_a_status_says_why_and_by_whom() -> None:
    why = word('/switch', stopped=True, topic=STATUS, reason='a button was pressed', by='/pad')
    state = heard((b'a', word('/switch', stopped=True)), (b's', why))
    assert (state.reason, state.by) == ('a button was pressed', '/pad')
    named = word('/switch', stopped=True, topic=STATUS, reason='/pad pressed the button', by='/pad')
    assert heard((b's', named)).by == '', 'the reason names it'


def test_a_voice_that_repeated_itself_and_falls_silent_is_never_fine() -> None:
    state = heard((b'a', word('/a', stopped=False)))
    for _ in range(REPEATS):
        state.hear(b'a', word('/a', stopped=False))
    for _ in range(SILENT_AFTER):
        state.look()
    assert standing(state) is Standing.RELEASED
    state.look()
    assert standing(state) is Standing.UNKNOWN
    assert state.reason == '/a has fallen silent on /emergency_stopped. It last said: not stopped'
    state.hear(b'a', word('/a', stopped=False))
    assert standing(state) is Standing.RELEASED


def test_presses_that_repeat_stopped_are_no_clock() -> None:
    state = heard((b'a', word('/a', stopped=True)))
    for _ in range(3 * REPEATS):
        state.look()
        state.hear(b'a', word('/a', stopped=True))
    state.hear(b'a', word('/a', stopped=False))
    for _ in range(2 * SILENT_AFTER):
        state.look()
    assert standing(state) is Standing.RELEASED


def test_a_silent_voice_that_said_stopped_stays_stopped() -> None:
    state = heard((b'a', word('/a', stopped=True)))
    state.hear(b'a', word('/a', stopped=True))
    for _ in range(2 * SILENT_AFTER):
        state.look()
    assert standing(state) is Standing.STOPPED


def test_a_latched_word_that_is_said_once_does_not_grow_old() -> None:
    state = heard((b'a', word('/a', stopped=False)))
    for _ in range(10 * SILENT_AFTER):
        state.look()
    assert standing(state) is Standing.RELEASED
    state.hear(b'a', word('/a', stopped=True))
    state.hear(b'a', word('/a', stopped=False))
    for _ in range(10 * SILENT_AFTER):
        state.look()
    assert standing(state) is Standing.RELEASED


def test_a_publisher_that_has_gone_is_missed_until_its_node_or_a_switch_speaks() -> None:
    state = heard((b'a', word('/a', stopped=True)))
    state.keep(set())
    assert standing(state) is Standing.UNKNOWN
    assert state.reason == '/a, which told it on /emergency_stopped, has gone. It last said: stopped'
    state.hear(b'x', word('/stranger', stopped=False))
    assert standing(state) is Standing.UNKNOWN
    state.hear(b'y', word('/a', stopped=False))
    assert standing(state) is Standing.RELEASED
    state.keep(set())
    state.keep({(STATE, b'x'), (STATE, b'y')})
    state.keep({(STATE, b'x')})
    state.hear(b's', word('/switch', stopped=False, is_switch=True))
    assert standing(state) is Standing.RELEASED


def test_a_publisher_that_the_graph_shows_later_than_its_message_is_kept() -> None:
    state = EmergencyState()
    state.hear(b'a', word('/a', stopped=True))
    state.keep(set())
    assert standing(state) is Standing.STOPPED


def test_servers_that_have_gone_are_remembered_for_one_more_try() -> None:
    state = EmergencyState()
    setbool, trigger = StopService('/e', 'std_srvs/srv/SetBool'), StopService('/t', 'std_srvs/srv/Trigger')
    state.serve([setbool, trigger])
    released = state.can_release
    state.serve([])
    assert (released, state.can_release) == ((setbool,), ())
    assert (state.servers, state.known) == ((), (setbool, trigger))


# -- whose a name is -----------------------------------------------------------------------------------------


def test_a_name_is_of_the_robot_with_the_longest_namespace() -> None:
    assert owner('/alice/arm/follow', ['/alice', '/alice/arm', '/bob']) == '/alice/arm'
    assert owner('/alice2/go', ['/alice']) is None
    assert owner('/go', ['', '/alice']) == ''
    assert owner('/alice/go', ['', '/alice']) == '/alice'


def test_what_moves_a_robot_is_its_own_or_the_only_robots() -> None:
    assert may_move('/alice/go', '/alice', ['/alice', '/bob'])
    assert not may_move('/alice/go', '/bob', ['/alice', '/bob'])
    assert not may_move('/go', '/bob', ['/alice', '/bob']), 'it could move either'
    assert may_move('/go', '/bob', ['/bob'])
    assert not may_move('/alice/go', '/bob', ['/bob']), 'that of a robot that has gone'


def test_a_stop_above_several_robots_stops_each_of_them() -> None:
    robots = ['/hall/alice', '/hall/bob']
    assert all(may_stop('/hall/estop', robot, robots) for robot in robots)
    assert all(may_stop('/estop', robot, robots) for robot in robots)
    assert not may_stop('/hall/alice/estop', '/hall/bob', robots)
    assert not may_stop('/yard/estop', '/hall/bob', robots)
