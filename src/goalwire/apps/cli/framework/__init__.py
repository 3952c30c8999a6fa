"""Shared by all commands: nouns and verbs, output, failures, the graph, values."""
