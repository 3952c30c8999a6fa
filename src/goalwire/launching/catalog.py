"""Every tag and every substitution that XML and YAML launch files may use without an extension.

Importing a module adds its classes to the tables of `exposure.py`; this module imports all of them. The
overlay's `launch`, `launch_xml` and `launch_yaml` import this module, and so does the command line.
"""

from goalwire.launching import (
    actions,
    condition_substitutions,
    execute_process,
    ros,
    scopes,
    sources,
    substitutions,
)

__all__ = [
    'actions',
    'condition_substitutions',
    'execute_process',
    'ros',
    'scopes',
    'sources',
    'substitutions',
]
