"""The RAP interpreter: memory, tasks, agenda, monitors, and the port to worlds."""
