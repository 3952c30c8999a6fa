"""The arms: the checks that refuse goals, and the actions that move the joints."""
