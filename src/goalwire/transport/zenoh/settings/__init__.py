"""The configuration of a session: from the environment and its files to what a session is opened with."""
