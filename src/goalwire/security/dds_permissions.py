"""A policy as the permissions of DDS Security, for robots on DDS that have its plugins.

The rules of a permissions document are asked in their order, and the first whose topics match decides. So
the verbs of actions and parameters come first, then a rule that denies those topics, and then the wide verbs:
"all services, but not those for parameters" is two rules. Topics of ROS 2 on DDS are `rt/name`,
`rq/nameRequest` and `rr/nameReply`; sources: sros2 `permissions.xsl`, DDS Security 1.1, 9.4.1.

In DDS `*` stands for any characters, also for slashes. `inexpressible` lists the patterns that allow more
because of that.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import datetime
from typing import NamedTuple
from xml.etree import ElementTree as ET

from goalwire.security.needs import READING, SETTING
from goalwire.security.policy import Grant, Policy, Verb

LARGEST_DOMAIN = 232
DISCOVERY = 'ros_discovery_info'
"""The topic on which ROS 2's DDS middlewares announce which endpoint belongs to which node: everybody may use
it.
"""

_CALLS = {
    Verb.CALL: ('',),
    Verb.SEND: ('/_action/send_goal', '/_action/get_result'),
    Verb.WATCH: ('/_action/get_result',),
    Verb.CANCEL: ('/_action/cancel_goal',),
    Verb.READ: tuple(f'/{each}' for each in READING),
    Verb.SET: tuple(f'/{each}' for each in SETTING),
}
"""The ends of the names of the services that each verb calls."""
_OF_ACTIONS = ('/_action/send_goal', '/_action/get_result', '/_action/cancel_goal')
_FEEDS = ('/_action/feedback', '/_action/status')
_WIDE = (Verb.CALL, Verb.PUBLISH, Verb.SUBSCRIBE)


class Topics(NamedTuple):
    """The DDS topics of a rule."""

    published: tuple[str, ...]
    subscribed: tuple[str, ...]


class Rule(NamedTuple):
    """One rule of a permissions document: the topics, and the domains in which it holds (empty: all)."""

    allows: bool
    domains: tuple[int, ...]
    topics: Topics


def rules_of(grants: Iterable[Grant]) -> list[Rule]:
    """Return the rules of an identity, in their order."""
    grants = list(grants)
    narrow = [grant for grant in grants if grant.verb not in _WIDE]
    wide = [grant for grant in grants if grant.verb in _WIDE]
    return [*_allowing(narrow), _DENIED, *_allowing(wide), Rule(True, (), Topics((DISCOVERY,), (DISCOVERY,)))]


def _allowing(grants: list[Grant]) -> Iterator[Rule]:
    """Yield one rule for all grants that hold in the same domains."""
    for domains in dict.fromkeys(grant.domains for grant in grants):
        found = [_topics_of(grant) for grant in grants if grant.domains == domains]
        published = tuple(dict.fromkeys(topic for each in found for topic in each.published))
        subscribed = tuple(dict.fromkeys(topic for each in found for topic in each.subscribed))
        if published or subscribed:
            yield Rule(True, domains, Topics(published, subscribed))


def _topics_of(grant: Grant) -> Topics:
    names = list(_names(grant.pattern))
    calls = _CALLS.get(grant.verb, ())
    published = [f'rq{name}{end}Request' for name in names for end in calls]
    subscribed = [f'rr{name}{end}Reply' for name in names for end in calls]
    if grant.verb is Verb.PUBLISH:
        published += [f'rt{name}' for name in names]
    if grant.verb is Verb.SUBSCRIBE:
        subscribed += [f'rt{name}' for name in names]
    if grant.verb in {Verb.SEND, Verb.WATCH}:
        subscribed += [f'rt{name}{feed}' for name in names for feed in _FEEDS]
    if grant.verb is Verb.SERVE:
        served = [f'{name}{end}' for name in names for end in ('', *_OF_ACTIONS)]
        published += [f'rr{name}Reply' for name in served]
        published += [f'rt{name}{feed}' for name in names for feed in _FEEDS]
        subscribed += [f'rq{name}Request' for name in served]
    return Topics(tuple(published), tuple(subscribed))


def _names(pattern: str) -> Iterator[str]:
    """Yield the expressions of DDS for a pattern of names: '/arm/**' is '/arm', and '/arm/*'."""
    above, _, last = pattern.rpartition('/')
    if last != '**':
        yield pattern.replace('**', '*')
        return
    if above:
        yield above.replace('**', '*')
    yield above.replace('**', '*') + '/*'


_CALLED_ONLY_BY_NAME = (*_OF_ACTIONS, *(f'/{each}' for each in (*READING, *SETTING)))
_DENIED = Rule(
    False,
    (),
    Topics(
        (
            *(f'rq/*{end}Request' for end in _CALLED_ONLY_BY_NAME),
            *(f'rt/*{feed}' for feed in _FEEDS),
        ),
        (
            *(f'rr/*{end}Reply' for end in _CALLED_ONLY_BY_NAME),
            *(f'rt/*{feed}' for feed in _FEEDS),
        ),
    ),
)
"""A rule that denies the topics that the wide verbs do not cover."""


def inexpressible(policy: Policy) -> list[str]:
    """Return sentences about names that DDS allows beyond the policy."""
    return [
        f"DDS lets '{who}' {grant.verb.value} more than {grant.pattern}: its '*' also stands for slashes"
        for who, grants in policy.grants.items()
        for grant in grants
        if grant.verb not in {Verb.RUN, Verb.INTROSPECT} and '*' in grant.pattern.removesuffix('/**')
    ]


# ---- as XML


def permissions_xml(subject: str, grants: Iterable[Grant], validity: tuple[datetime, datetime]) -> bytes:
    """Return the permissions document of a certificate's subject, such as 'CN=/robby'."""
    root = ET.Element('dds')
    grant = ET.SubElement(ET.SubElement(root, 'permissions'), 'grant', name=subject.removeprefix('CN='))
    ET.SubElement(grant, 'subject_name').text = subject
    times = ET.SubElement(grant, 'validity')
    for name, time in zip(('not_before', 'not_after'), validity, strict=True):
        ET.SubElement(times, name).text = f'{time:%Y-%m-%dT%H:%M:%S}'
    for rule in rules_of(grants):
        _add_rule(grant, rule)
    ET.SubElement(grant, 'default').text = 'DENY'
    return _text(root)


def _add_rule(grant: ET.Element, rule: Rule) -> None:
    element = ET.SubElement(grant, 'allow_rule' if rule.allows else 'deny_rule')
    _add_domains(element, rule.domains)
    for name, topics in zip(('publish', 'subscribe'), rule.topics, strict=True):
        if topics:
            listed = ET.SubElement(ET.SubElement(element, name), 'topics')
            for topic in topics:
                ET.SubElement(listed, 'topic').text = topic


def _add_domains(parent: ET.Element, domains: tuple[int, ...]) -> None:
    element = ET.SubElement(parent, 'domains')
    for domain in domains:
        ET.SubElement(element, 'id').text = str(domain)
    if not domains:
        every = ET.SubElement(element, 'id_range')
        ET.SubElement(every, 'min').text = '0'
        ET.SubElement(every, 'max').text = str(LARGEST_DOMAIN)


def governance_xml() -> bytes:
    """Return the governance document: everything is encrypted, and access to every topic is checked."""
    root = ET.Element('dds')
    rule = ET.SubElement(ET.SubElement(root, 'domain_access_rules'), 'domain_rule')
    _add_domains(rule, ())
    for name, value in (
        ('allow_unauthenticated_participants', 'false'),
        ('enable_join_access_control', 'true'),
        ('discovery_protection_kind', 'ENCRYPT'),
        ('liveliness_protection_kind', 'ENCRYPT'),
        ('rtps_protection_kind', 'SIGN'),
    ):
        ET.SubElement(rule, name).text = value
    topic = ET.SubElement(ET.SubElement(rule, 'topic_access_rules'), 'topic_rule')
    for name, value in (
        ('topic_expression', '*'),
        ('enable_discovery_protection', 'true'),
        ('enable_liveliness_protection', 'true'),
        ('enable_read_access_control', 'true'),
        ('enable_write_access_control', 'true'),
        ('metadata_protection_kind', 'ENCRYPT'),
        ('data_protection_kind', 'ENCRYPT'),
    ):
        ET.SubElement(topic, name).text = value
    return _text(root)


def _text(root: ET.Element) -> bytes:
    ET.indent(root)
    text: str = ET.tostring(root, encoding='unicode')
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()
