"""The typed, frozen intermediate representation of RAP programs."""
