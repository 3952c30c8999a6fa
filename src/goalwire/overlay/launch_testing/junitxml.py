"""launch_testing.junitxml: writes test results in JUnit's XML format."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree as ET

from launch_testing.test_result import Result

__all__ = ['unittestResultsToXml']


def unittestResultsToXml(*, name: str = 'launch_test', test_results: Mapping[Any, Result]) -> Any:
    """Return the results as XML in JUnit's format: a suite for each run, a case for each test."""
    top = ET.Element('testsuites', name=name)
    for run_, result in test_results.items():
        counts = {kind: str(len(getattr(result, kind))) for kind in ('failures', 'errors', 'skipped')}
        seconds = f'{sum(result.testTimes.values()):.3f}'
        suite = ET.SubElement(
            top, 'testsuite', counts, name=str(run_), tests=str(result.testsRun), time=seconds
        )
        told = {
            id(case): (tag, text)
            for tag, kind in (('failure', 'failures'), ('error', 'errors'), ('skipped', 'skipped'))
            for case, text in getattr(result, kind)
        }
        for case, taken in result.testTimes.items():
            owner, _, method = case.id().rpartition('.')
            element = ET.SubElement(suite, 'testcase', classname=owner, name=method, time=f'{taken:.3f}')
            if id(case) in told:
                tag, text = told[id(case)]
                ET.SubElement(element, tag, message=text)
    for kind in ('tests', 'failures', 'errors'):
        top.set(kind, str(sum(int(suite.get(kind, '0')) for suite in top)))
    return ET.ElementTree(top)
