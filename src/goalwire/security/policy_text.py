"""The text of a policy.toml: makes the first one, and adds identities to it."""

from __future__ import annotations

import tomllib

from goalwire.errors import SecurityError
from goalwire.patterns import Pattern

FIRST_POLICY = """\
# Who may do what. Nothing is allowed that no line here allows. After a change: goalwire secure check
# Verbs: run (have a node of that name), publish, subscribe, call, serve (services and actions),
# send, cancel, watch (goals of actions), read, set (parameters of nodes), introspect (see the graph).
# Names: '*' is any part of a name between slashes, '/**' any number of them.
# missions = true: answer, resume and undo missions in a console.

mode = "enforce"  # or "audit": all is let through, and what would be refused is logged

[everyone]  # what each identity below may do
publish = ["/rosout", "/parameter_events", "/diagnostics"]
subscribe = ["/parameter_events", "/clock"]

[roles.robot]
run = ["/**"]
publish = ["/**"]
subscribe = ["/**"]
call = ["/**"]
serve = ["/**"]
send = ["/**"]
cancel = ["/**"]
watch = ["/**"]
read = ["/**"]
set = ["/**"]
introspect = ["/**"]

[roles.operator]
run = ["/**"]
serve = ["/_ros2cli*/**", "/_goalwire_doctor*/**"]
publish = ["/cmd_vel"]
subscribe = ["/**"]
call = ["/**"]
send = ["/**"]
cancel = ["/**"]
watch = ["/**"]
read = ["/**"]
introspect = ["/**"]
missions = true

[roles.viewer]
run = ["/**"]
serve = ["/_ros2cli*/**"]
subscribe = ["/**"]
watch = ["/**"]
read = ["/**"]
introspect = ["/**"]

[roles.console]  # of goalwire console and of bridges, which ask about each person who signs in there, too
run = ["/**"]
serve = ["/goalwire_console*/**", "/rosbridge*/**", "/foxglove*/**"]
publish = ["/**"]
subscribe = ["/**"]
call = ["/**"]
send = ["/**"]
cancel = ["/**"]
watch = ["/**"]
read = ["/**"]
set = ["/**"]
introspect = ["/**"]
missions = true

[identities]  # who has which of these roles
"""

_TABLE = Pattern(r'\s*\[')
_IDENTITIES = Pattern(r'\s*\[\s*identities\s*\]')


def add_identity(text: str, name: str, roles: tuple[str, ...]) -> str:
    """Return a policy's text with one more identity in it; one that is named already stays as it is.

    All else is kept as people have written it. Raises SecurityError for a text that cannot be read, and for
    a role that it does not have.
    """
    try:
        found = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SecurityError(f'policy.toml cannot be read: {error}') from None
    for role in roles:
        if role not in found.get('roles', {}):
            known = ', '.join(found.get('roles', {})) or 'none'
            raise SecurityError(f"policy.toml has no role '{role}'; it has {known}")
    if name in found.get('identities', {}):
        return text
    quoted = ', '.join(f'"{role}"' for role in roles)
    line = f'"{name}" = [{quoted}]'
    lines = text.splitlines()
    at = next((at for at, each in enumerate(lines) if _IDENTITIES.match(each)), None)
    if at is None:
        return '\n'.join([*lines, '', '[identities]', line]) + '\n'
    end = next((end for end in range(at + 1, len(lines)) if _TABLE.match(lines[end])), len(lines))
    while end > at + 1 and not lines[end - 1].strip():
        end -= 1
    return '\n'.join([*lines[:end], line, *lines[end:]]) + '\n'
