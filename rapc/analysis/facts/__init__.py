"""Facts about a library that several checks need; each fact is computed once."""
