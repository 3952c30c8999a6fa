"""goalwire top: nodes, topics, services, goals and log lines on one screen."""
