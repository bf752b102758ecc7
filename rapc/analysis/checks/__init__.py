"""The checks and their rules, by subject."""
