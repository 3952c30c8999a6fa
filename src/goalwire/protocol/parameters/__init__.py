"""Parameters: typed values under a name, what may be set, and who is asked."""

from goalwire.protocol.parameters.callbacks import CallbackError, SetCallbacks
from goalwire.protocol.parameters.descriptor import RELATIVE_TOLERANCE, Descriptor, Range
from goalwire.protocol.parameters.listing import SEPARATOR
from goalwire.protocol.parameters.outcome import ACCEPTED, Outcome, WrongType, refused
from goalwire.protocol.parameters.parameter import Parameter, ParameterValue, Type
from goalwire.protocol.parameters.table import Changes, ParameterTable

__all__ = [
    'ACCEPTED',
    'RELATIVE_TOLERANCE',
    'SEPARATOR',
    'CallbackError',
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
    'refused',
]
