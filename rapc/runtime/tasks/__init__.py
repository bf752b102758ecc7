"""The loop of a run, and the life of tasks: start, choice, cycle, end (T 3.4.1)."""
