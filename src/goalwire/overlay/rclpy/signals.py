"""rclpy.signals: installs and removes the handlers of SIGINT and SIGTERM."""

from goalwire.execution.signals.signal_handlers import (
    SignalHandlerGuardCondition,
    SignalHandlerOptions,
    get_current_signal_handlers_options,
    install_signal_handlers,
    uninstall_signal_handlers,
)
from rclpy._reexports import reexport

__all__ = [
    'SignalHandlerGuardCondition',
    'SignalHandlerOptions',
    'get_current_signal_handlers_options',
    'install_signal_handlers',
    'uninstall_signal_handlers',
]

reexport(__name__)
