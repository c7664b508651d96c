"""Mouse and keys over the viewport as pure functions: tools, gestures, selection."""
