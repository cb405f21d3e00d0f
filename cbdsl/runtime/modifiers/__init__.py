"""Built-in modifiers, one per file."""
