"""The commands, each noun a module or a folder that holds its `NOUN`."""
