"""Formulas into generated code."""
