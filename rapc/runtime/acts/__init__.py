"""What the robot does: requests to the world and their replies (T 3.3)."""
