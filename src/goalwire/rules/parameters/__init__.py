"""The rules of parameters: typed values, descriptors, callbacks, files; no I/O."""

from goalwire.rules.parameters.callbacks import SetCallbacks
from goalwire.rules.parameters.descriptor import RELATIVE_TOLERANCE, Descriptor, Range
from goalwire.rules.parameters.listing import SEPARATOR
from goalwire.rules.parameters.outcome import ACCEPTED, Outcome, WrongType, refuse
from goalwire.rules.parameters.parameter import Parameter, ParameterValue, Type
from goalwire.rules.parameters.table import Changes, ParameterTable

__all__ = [
    'ACCEPTED',
    'RELATIVE_TOLERANCE',
    'SEPARATOR',
    'Changes',
    'Descriptor',
    'Outcome',
    'Parameter',
    'ParameterTable',
    'ParameterValue',
    'Range',
    'SetCallbacks',
    'Type',
    'WrongType',
    'refuse',
]
