"""Whether a world keeps to the port: what `rapc worlds NAME --test` tries."""
