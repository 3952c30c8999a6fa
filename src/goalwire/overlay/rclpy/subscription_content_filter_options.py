"""rclpy.subscription_content_filter_options: filters messages by their content."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class ContentFilterOptions(NamedTuple):
    """A DDS filter: 'x > %0' with '%0' from the parameters."""

    filter_expression: str
    expression_parameters: Sequence[str]
