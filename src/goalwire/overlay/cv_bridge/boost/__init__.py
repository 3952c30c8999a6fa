"""The package that has the name of cv_bridge's compiled part, since programs import it."""
