"""What a person types to a session, and what is shown: commands, tables, the prompt."""
