"""Journals: runs on disk that go on after the end of their process."""
