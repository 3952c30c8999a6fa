"""launch_yaml.parser."""

from goalwire.launching.frontend import YAMLParser as Parser

__all__ = ['Parser']
