"""Events of a run as values, their recorder, and traces of events."""
