"""Outcomes and coverage of tests as text: for terminals, pytest, JUnit and JSON."""
