"""launch_xml.parser."""

from goalwire.launching.frontend import XMLParser as Parser

__all__ = ['Parser']
