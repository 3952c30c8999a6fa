"""The folder of cv_bridge's compiled part, under whose name programs import it."""
