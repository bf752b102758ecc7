"""Special readers, data to IR: a module for each form, a function for each clause."""
