"""The language server: findings, completion, hover, definitions and fixes, while one types."""
