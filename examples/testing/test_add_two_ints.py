"""Tests a service and its client, each without the other half. The programs are those of examples/.

python -m pytest examples/testing
"""

import add_two_ints_client
import add_two_ints_server
import pytest
from example_interfaces.srv import AddTwoInts

from goalwire import CallError
from goalwire.testing import NEVER, after


def test_the_server_adds(gw_graph):
    gw_graph.start(add_two_ints_server.AddTwoIntsServer)
    assert gw_graph.call(AddTwoInts, 'add_two_ints', a=2, b=40).sum == 42


def test_the_client_asks_and_prints_the_answer(gw_clock, gw_graph, capsys):
    service = gw_graph.service(AddTwoInts, 'add_two_ints', AddTwoInts.Response(sum=7))
    assert gw_graph.run(add_two_ints_client.main, '2', '3').wait() is None
    service.assert_called_with(a=2, b=3)
    assert capsys.readouterr().out == '2 + 3 = 7\n'


def test_the_client_waits_for_a_slow_server(gw_clock, gw_graph):
    gw_graph.service(AddTwoInts, 'add_two_ints', after(4.9, AddTwoInts.Response(sum=7)))
    assert gw_graph.run(add_two_ints_client.main, '2', '3').wait() is None
    assert gw_clock.elapsed == pytest.approx(4.9)


def test_the_client_gives_up_after_five_seconds(gw_clock, gw_graph):
    gw_graph.service(AddTwoInts, 'add_two_ints', NEVER)
    assert gw_graph.run(add_two_ints_client.main, '2', '3').wait(timeout=60) == 1
    assert gw_clock.elapsed == pytest.approx(5.0)


def test_without_a_server_the_client_gives_up_after_ten_seconds(gw_clock, gw_graph):
    assert gw_graph.run(add_two_ints_client.main, '2', '3').wait(timeout=60) == 1
    assert gw_clock.elapsed == pytest.approx(10.0)


def test_what_the_server_cannot_add_fails_the_call(gw_graph):
    gw_graph.service(AddTwoInts, 'add_two_ints', OverflowError('too large'))
    with pytest.raises(CallError, match='too large'):
        gw_graph.call(AddTwoInts, 'add_two_ints', a=2**62, b=2**62)
