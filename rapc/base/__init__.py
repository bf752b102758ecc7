"""What knows nothing of RAP: sources, files, findings, values, pictures."""
