"""The package of cv_bridge's compiled part, under the name that programs import."""
