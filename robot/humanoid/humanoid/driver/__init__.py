"""Real motors: the interface for drivers, an example driver for a serial line, a simulated motor board."""
