"""How rosidl names the Python module of a type: std_srvs.srv._set_bool holds SetBool."""

import re

_WORD = re.compile('(.)([A-Z][a-z]+)')
_BOUNDARY = re.compile('([a-z0-9])([A-Z])')


def module_name(type_name: str) -> str:
    """Return '_set_bool' for 'SetBool', '_tf2_error' for 'TF2Error', '_u_int8' for 'UInt8'.

    rosidl's rule (convert_camel_case_to_lower_case_underscore): an underscore before each capital that starts
    a word and between a small letter or digit and a capital, then all in lower case.
    """
    spaced = _BOUNDARY.sub(r'\1_\2', _WORD.sub(r'\1_\2', type_name))
    return '_' + spaced.lower()
