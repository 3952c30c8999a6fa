"""goalwire secure: its verbs. The module of a verb is imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'secure',
    'Keep strangers out: keys, certificates, and who may do what',
    (
        Verb(
            'add',
            'Make an identity: a robot, a person, a program or a router',
            *lazy('secure.identities', 'make_identity'),
        ),
        Verb(
            'audit',
            'Read what an identity has refused, and check the log',
            *lazy('secure.inspection', 'audit'),
        ),
        Verb(
            'authority',
            'Renew certificates over the network, for programs that run',
            *lazy('secure.authority'),
        ),
        Verb('check', 'Check a keystore and its policy', *lazy('secure.inspection', 'check_keystore')),
        Verb(
            'config',
            "Print settings for rmw_zenoh's router and sessions",
            *lazy('secure.carrying', 'print_settings'),
        ),
        Verb(
            'dds',
            'Write a keystore of ROS 2 for DDS Security, with the same policy',
            *lazy('secure.carrying', 'write_dds'),
        ),
        Verb(
            'explain',
            'Say whether somebody may do something, and which line decides',
            *lazy('secure.inspection', 'explain'),
        ),
        Verb(
            'export',
            'Write an identity into one file, to be carried to its machine',
            *lazy('secure.carrying', 'export_identity'),
        ),
        Verb('import', 'Take an identity from a file', *lazy('secure.carrying', 'take_identity')),
        Verb(
            'init',
            'Make a keystore with new authorities and a first policy',
            *lazy('secure.identities', 'make_keystore'),
        ),
        Verb(
            'issue',
            'Make a new key for a name without one, as after revoke',
            *lazy('secure.identities', 'issue'),
        ),
        Verb(
            'learn',
            'Watch a system at work, and write the policy that it needs',
            *lazy('secure.learn'),
            has_json=False,
        ),
        Verb('list', 'List the identities of a keystore', *lazy('secure.identities', 'list_identities')),
        Verb('renew', 'Give identities new keys and certificates', *lazy('secure.identities', 'renew')),
        Verb(
            'revoke',
            'Refuse all certificates and tokens that a name has now',
            *lazy('secure.identities', 'revoke'),
        ),
        Verb(
            'token',
            'Make a token with which a name signs in at a console or bridge',
            *lazy('secure.identities', 'give_token'),
        ),
    ),
)
