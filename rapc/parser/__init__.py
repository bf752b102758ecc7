"""From text to IR: the data reader, one file per form, and back to text."""
