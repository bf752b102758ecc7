"""The rules that the front end can find broken, each with its manual page."""
