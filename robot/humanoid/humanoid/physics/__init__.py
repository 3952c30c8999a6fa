"""The humanoid in MuJoCo: its world, its gait, and the program that runs both. Needs the extra `sim`."""
