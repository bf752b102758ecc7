"""The front end: reading, recovering, forms, printing."""
