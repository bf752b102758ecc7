"""One file per top-level form: data to IR, one function per clause."""
