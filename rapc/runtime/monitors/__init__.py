"""Waiting: for states of memory, for times, and past deadlines (T 4.7)."""
