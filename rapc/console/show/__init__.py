"""The live view of a run: what is true in a world beside what the robot believes."""
