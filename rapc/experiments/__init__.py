"""Experiments: batches of seeded runs, what they measured, tables and plots (T 6.3)."""
