"""Messages as plain data."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import Point
from sensor_msgs.msg import JointState

from goalwire.errors import UnknownInterfaceError
from goalwire.observe.messages import as_data, as_dict, interface_class, plain


def test_messages_become_data_that_json_can_hold() -> None:
    data = as_data(JointState(name=['x' * 5000], position=[float('nan'), *range(500)]))
    assert data['position'][0] == 'nan'
    assert len(data['position']) == 201
    assert data['position'][-1] == '… 501 items'
    assert len(data['name'][0]) < 2100
    assert as_data(2**60) == str(2**60)
    octets = as_data(bytes(1_000_000))
    assert (len(octets), octets[-1]) == (201, '… 1000000 items')


def test_a_message_is_whole_as_a_dictionary() -> None:
    state = JointState(name=['a'], position=[1.0, 2.0])
    assert as_dict(state)['position'] == [1.0, 2.0]
    assert as_dict(state)['header']['frame_id'] == ''
    assert plain(state.position) == [1.0, 2.0]
    assert plain([Point(x=1.0)]) == [{'x': 1.0, 'y': 0.0, 'z': 0.0}]


def test_a_type_is_found_by_its_name_or_its_absence_is_explained() -> None:
    assert interface_class('geometry_msgs/msg/Point') is Point
    with pytest.raises(UnknownInterfaceError, match="the type 'no_msgs/msg/Thing' is not known here"):
        interface_class('no_msgs/msg/Thing')
