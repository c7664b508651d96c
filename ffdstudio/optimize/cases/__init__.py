"""Case files: studies described in TOML."""
