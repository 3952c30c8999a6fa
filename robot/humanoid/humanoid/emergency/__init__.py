"""The emergency stop: one node has the switch, and all servers obey the switch.

`emergency_stop` is a service (std_srvs/SetBool: true stops, false releases) and a topic (std_msgs/Bool) for
buttons: true stops; false does nothing, because only the service releases. The topic `emergency_stopped`
(std_msgs/Bool, latched) tells the state, to late joiners too, and is repeated as long as there is a
switch. `emergency_stop_status` (diagnostic_msgs/DiagnosticStatus, latched) says why it is stopped, and who
did it.

Servers hear all publishers of `emergency_stopped` and tell them apart: humanoid.emergency.votes has the
rules. A server that no longer hears the switch stops: nobody could stop it otherwise. It then presses
the button of the next switch that it hears. So a switch that has restarted is thrown, and must be released.
"""
