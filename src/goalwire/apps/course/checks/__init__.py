"""The steps of each exercise's check: a module an exercise, with `steps(file)`, which raises Wrong."""
