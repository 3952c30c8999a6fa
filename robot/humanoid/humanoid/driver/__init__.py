"""Real motors: the seam for a driver, an example that speaks over a serial line, and its motor board."""
