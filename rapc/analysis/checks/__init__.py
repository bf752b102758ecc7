"""The checks, by subject: each with its rules."""
