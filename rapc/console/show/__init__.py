"""The live view of a run: the truth of a world beside the robot's beliefs."""
