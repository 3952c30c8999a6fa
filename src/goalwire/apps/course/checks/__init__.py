"""The steps of the checks: one module for each exercise, with a function `steps(file)` that raises Wrong."""
