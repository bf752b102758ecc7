"""Parts of the manual that `docs/generate.py` writes."""
