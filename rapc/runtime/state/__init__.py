"""The state of a run: plain records of tasks, methods and the agenda."""
