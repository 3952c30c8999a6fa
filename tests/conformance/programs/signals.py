"""Signal handlers: which are installed, by whom, for how long."""

import rclpy
from rclpy.context import Context
from rclpy.signals import (
    SignalHandlerOptions,
    get_current_signal_handlers_options,
    install_signal_handlers,
    uninstall_signal_handlers,
)

[SignalHandlerOptions(number).name for number in range(4)]
get_current_signal_handlers_options()


initialized = rclpy.init(args=[])
get_current_signal_handlers_options()
rclpy.shutdown()
get_current_signal_handlers_options()
initialized = rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.SIGTERM)
get_current_signal_handlers_options()
rclpy.shutdown(uninstall_handlers=False)
get_current_signal_handlers_options()
uninstall_signal_handlers()
get_current_signal_handlers_options()
install_signal_handlers(SignalHandlerOptions.SIGINT)
get_current_signal_handlers_options()
uninstall_signal_handlers()
install_signal_handlers(5)
context = Context()
own = rclpy.init(args=[], context=context)
get_current_signal_handlers_options()
rclpy.shutdown(context=context)
