"""Tests of the language in the language itself, and what they need from Python."""
