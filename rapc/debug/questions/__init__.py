"""Questions to a history, one module for each subject."""
