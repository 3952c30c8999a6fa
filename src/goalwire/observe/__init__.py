"""Observes a robot from another program: goals, rates, service calls, parameters, log lines and messages.

The command line, `goalwire top` and the console all use this package, so that two screens that show
the same thing show the same figure.
"""
