"""Language server: findings, completion, hover, definitions and fixes during editing."""
