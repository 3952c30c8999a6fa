"""Every tag and every substitution that XML and YAML launch files may use without an extension.

The classes add themselves to the tables of `exposure.py` when their modules are imported. The overlay's
`launch`, `launch_xml` and `launch_yaml` import this module, and so does the command line.
"""

from goalwire.launching import actions, process, ros, scopes, sources, substitutions

__all__ = ['actions', 'process', 'ros', 'scopes', 'sources', 'substitutions']
