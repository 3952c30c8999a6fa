"""The humanoid simulated in MuJoCo, and the program that runs the simulation. Needs the extra `sim`."""
