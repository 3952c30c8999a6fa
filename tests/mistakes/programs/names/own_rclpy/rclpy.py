"""My first program."""
