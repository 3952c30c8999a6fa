"""launch_testing_ros.tools.output: filters that also drop the output of an rmw implementation."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ament_index_python.resources import get_resource, has_resource
from launch_testing.tools import output

__all__ = ['basic_output_filter', 'get_rmw_output_filter']

_KINDS = ('prefixes', 'patterns')


def get_rmw_output_filter(rmw_implementation: str, filter_type: str) -> list[str]:
    """Return the prefixes, or the patterns, of lines that an rmw implementation prints.

    They are read from the implementation's resource `rmw_output_prefixes` or `rmw_output_patterns`; without
    this resource the list is empty. Raises TypeError for a `filter_type` of another type.
    """
    if filter_type not in _KINDS:
        raise TypeError(f'Unsupported filter_type "{filter_type}". Supported types: {list(_KINDS)}')
    resource = f'rmw_output_{filter_type}'
    if not has_resource(resource, rmw_implementation):
        return []
    content, _ = get_resource(resource, rmw_implementation)
    return content.splitlines()


def basic_output_filter(
    filtered_prefixes: Iterable[str] | None = None,
    filtered_patterns: Iterable[str] | None = None,
    filtered_rmw_implementation: str | None = None,
) -> Callable[[str], str]:
    """Return launch_testing's filter, which also drops the lines of an rmw implementation."""
    prefixes = list(
        output.get_default_filtered_prefixes() if filtered_prefixes is None else filtered_prefixes
    )
    patterns = list(
        output.get_default_filtered_patterns() if filtered_patterns is None else filtered_patterns
    )
    if filtered_rmw_implementation:
        prefixes += get_rmw_output_filter(filtered_rmw_implementation, 'prefixes')
        patterns += get_rmw_output_filter(filtered_rmw_implementation, 'patterns')
    return output.basic_output_filter(prefixes, patterns)
