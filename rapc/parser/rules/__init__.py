"""The rules that the front end reports, each with its manual page."""
