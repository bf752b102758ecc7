"""Tools without knowledge of RAP: sources, files, findings, values, pictures."""
