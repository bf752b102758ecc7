"""A second, plain memory that recognises, and what both must agree about."""
