"""Which names of others the graph takes in."""

from __future__ import annotations

import pytest

from goalwire.errors import RemoteError
from goalwire.transport.graph_names import check_names


@pytest.mark.parametrize('name', ['a\nb', '\x1b[2J', 'a\u202eb', 'a\u2028b', 'x' * 1001])
def test_a_name_that_no_log_can_show_is_refused(name: str) -> None:
    with pytest.raises(RemoteError, match='token: ') as caught:
        check_names('token', 'good', name)
    assert str(caught.value).isprintable()


def test_names_of_other_alphabets_are_names() -> None:
    check_names('token', '/größe', '日本語', 'x' * 1000, '')
