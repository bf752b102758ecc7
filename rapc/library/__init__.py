"""Loading and linking of RAP files into a library."""
