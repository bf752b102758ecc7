"""Tests of the hallway world: its building, its robot, its skills."""
