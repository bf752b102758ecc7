"""A whole run as bytes, and back: capture, rebuild, and the format."""
