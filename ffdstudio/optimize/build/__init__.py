"""A run from its description: the one place where it is built."""
