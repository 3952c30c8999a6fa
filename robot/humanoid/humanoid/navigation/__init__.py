"""The base: how it drives, which goals it takes, and the action that moves it."""
