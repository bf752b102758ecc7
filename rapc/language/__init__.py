"""The grammar of the language as data, with its words and atoms."""
