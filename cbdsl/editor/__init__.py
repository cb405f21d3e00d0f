"""Language server: diagnostics, completion, hover, definitions and fixes during editing."""
