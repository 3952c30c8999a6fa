"""Programs that pass messages on without reading them: package `topic_tools`."""
