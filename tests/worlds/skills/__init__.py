"""Tests of the runtime for networks of skills."""
