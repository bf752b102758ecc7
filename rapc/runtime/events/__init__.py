"""What happens in a run: events as values, their recorder, and traces of them."""
