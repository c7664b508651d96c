"""The flow about a section, and pressures to match."""
