"""The joints: where they are, where they are told to go, and the service that says so."""
