"""What happens in a run: events as values, who is told, and how they are written."""
