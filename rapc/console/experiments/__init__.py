"""Figures of experiments as tables and plots, for terminals and Markdown."""
