"""What a run is made of: plain records of tasks, methods and the agenda."""
