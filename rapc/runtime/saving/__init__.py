"""A whole run as bytes, and back [docs/python.md]: capture, rebuild, and the format."""
