"""Output for terminals: findings, graphs, tables, pictures."""
