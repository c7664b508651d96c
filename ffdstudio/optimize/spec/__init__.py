"""One description of a study: a frozen value that the window, TOML, Python and projects share."""
