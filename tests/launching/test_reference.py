"""The reference names every tag and every substitution, and nothing else."""

from __future__ import annotations

import re

from helpers.markdown import DOCS, rows
from launch import actions, substitutions
from launch_ros import actions as ros_actions

from goalwire.launching import exposure
from goalwire.launching.expressions import FUNCTIONS

PAGE = DOCS / 'reference' / 'launch-files.md'
OF_TESTS = {'shout', 'upper'}


def test_every_tag_is_in_the_table() -> None:
    exposure.load_extensions()
    named = {tag for row in rows(PAGE, 'tag') for tag in re.findall(r'`([^`]+)`', row[0])}
    assert named == exposure.list_exposed_actions() - OF_TESTS


def test_every_substitution_is_in_the_table() -> None:
    exposure.load_extensions()
    named = {name for row in rows(PAGE, 'name') for name in re.findall(r'`([^`]+)`', row[0])}
    assert named == exposure.list_exposed_substitutions() - OF_TESTS


def test_every_class_is_on_the_page() -> None:
    text = PAGE.read_text()
    for name in {*actions.__all__, *substitutions.__all__, *ros_actions.__all__} - {'SubstitutionFailure'}:
        assert f'`{name}`' in text or name == 'PushROSNamespace', name


def test_the_functions_of_expressions_are_on_the_page() -> None:
    text = PAGE.read_text()
    assert all(f'`{name}`' in text for name in FUNCTIONS)
