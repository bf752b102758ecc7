"""From files to a library."""
