"""The base: how it drives, which goals it accepts, and the action that moves it."""
