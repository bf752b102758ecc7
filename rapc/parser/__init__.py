"""From text to IR and back: reader, parsers of forms, formatter."""
