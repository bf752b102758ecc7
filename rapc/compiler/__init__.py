"""IR to executable form: queries, terms, plans of methods."""
