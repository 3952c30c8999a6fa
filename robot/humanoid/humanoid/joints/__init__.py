"""The joints: their states, their commands, and the service that reports and moves them."""
