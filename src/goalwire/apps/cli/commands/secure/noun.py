"""goalwire secure: its verbs. Each has a module in this folder, imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'secure',
    'Keep strangers out: keys, certificates, and who may do what',
    (
        Verb('add', 'Make an identity: a robot, a person, a program or a router', *lazy('secure.add')),
        Verb('audit', 'Read what an identity has refused, and check the log', *lazy('secure.audit')),
        Verb(
            'authority',
            'Renew certificates over the network, for programs that run',
            *lazy('secure.authority'),
        ),
        Verb('check', 'Check a keystore and its policy', *lazy('secure.check')),
        Verb(
            'config',
            "Print settings for rmw_zenoh's router and sessions",
            *lazy('secure.config'),
        ),
        Verb('dds', 'Write a keystore of ROS 2 for DDS Security, with the same policy', *lazy('secure.dds')),
        Verb(
            'explain',
            'Say whether somebody may do something, and which line decides',
            *lazy('secure.explain'),
        ),
        Verb(
            'export', 'Write an identity into one file, to be carried to its machine', *lazy('secure.export')
        ),
        Verb('import', 'Take an identity from a file', *lazy('secure.take')),
        Verb('init', 'Make a keystore with new authorities and a first policy', *lazy('secure.init')),
        Verb('issue', 'Make a new key for a name without one, as after revoke', *lazy('secure.issue')),
        Verb(
            'learn',
            'Watch a system at work, and write the policy that it needs',
            *lazy('secure.learn'),
            has_json=False,
        ),
        Verb('list', 'List the identities of a keystore', *lazy('secure.list')),
        Verb('renew', 'Give identities new keys and certificates', *lazy('secure.renew')),
        Verb('revoke', 'Refuse all certificates and tokens that a name has now', *lazy('secure.revoke')),
        Verb(
            'token', 'Make a token with which a name signs in at a console or bridge', *lazy('secure.token')
        ),
    ),
)
