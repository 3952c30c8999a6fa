"""The battery: what drains and charges it, and the service that reports its state."""
