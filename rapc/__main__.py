"""`python -m rapc`: the same as the command `rapc`."""

from rapc.cli.start import main

if __name__ == "__main__":
    main()
