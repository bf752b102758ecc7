"""The RAP memory: facts with stamps, items, the handlers' way in."""
