"""What a library says, gathered once for all checks."""
