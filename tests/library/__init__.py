"""Tests of compiled queries and of what monitors listen to."""
