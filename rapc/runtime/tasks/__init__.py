"""A task's life: how tasks start, choose, run, and end (T 3.4.1)."""
