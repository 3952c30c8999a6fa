"""Every tag and every substitution that XML and YAML launch files may use without an extension.

Each class adds itself to the tables of `exposure.py` when its module is imported. The overlay's
`launch`, `launch_xml` and `launch_yaml` import this module, and so does the command line.
"""

from goalwire.launching import actions, process, ros, scopes, sources, substitutions

__all__ = ['actions', 'process', 'ros', 'scopes', 'sources', 'substitutions']
