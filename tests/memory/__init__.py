"""Tests of the memory that recognises items [T 2.3]."""
