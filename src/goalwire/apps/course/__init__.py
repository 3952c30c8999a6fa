"""The course on services and actions: four exercises, and the checks of a student's work."""
