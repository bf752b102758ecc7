"""Reading on where parentheses are missing or too many."""
