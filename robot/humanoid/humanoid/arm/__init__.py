"""The arms: which goals they can meet, and the action that moves them."""
