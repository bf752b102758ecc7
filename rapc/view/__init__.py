"""Views of runs as one static HTML page, without server, network or library."""
