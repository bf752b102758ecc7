"""Recognition: which description is of which item [T 2.3]."""
