"""A second interpreter, for tests only, and what compares the two.

The plainest reading of docs/language, pages 2 to 6: slow, without indexes, compiled
queries or wake-up tables. `compare` runs random programs through both and expects the
same trace, event for event.
"""
