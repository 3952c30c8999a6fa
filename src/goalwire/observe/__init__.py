"""The robot as others see it: goals, rates, service calls, parameters, log lines and messages.

The command line, `goalwire top` and the console all show what is known here, so that two screens that show
one thing show one figure.
"""
