"""rclpy.subscription_content_filter_options: filters messages by their content."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class ContentFilterOptions(NamedTuple):
    """A content filter of DDS, for example 'x > %0', where '%0' stands for the first parameter."""

    filter_expression: str
    expression_parameters: Sequence[str]
