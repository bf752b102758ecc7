"""Views of runs as one HTML page, written to a file or served while the run goes on."""
