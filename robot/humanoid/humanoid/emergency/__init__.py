"""The emergency stop: one node has the switch, and all servers obey the switch.

`emergency_stop` is a service (std_srvs/SetBool: true stops, false releases) and a topic (std_msgs/Bool) for
buttons: true stops; false does nothing, because only the service releases. The topic `emergency_stopped`
(std_msgs/Bool, latched) has the state, for late joiners too, and is repeated as long as there is a
switch. `emergency_stop_status` (diagnostic_msgs/DiagnosticStatus, latched) says why the robot is stopped, and
who stopped it.

Servers hear all publishers of `emergency_stopped` and tell them apart: humanoid.emergency.votes has the
rules. A server that no longer hears the switch stops what it moves, since nobody else could stop it. The
server then presses the button of the next switch that it hears. So a restarted switch is thrown, and must be
released.
"""
