"""The world around the robot: its walls, doors, furniture and people, and what a scanner sees of them."""
