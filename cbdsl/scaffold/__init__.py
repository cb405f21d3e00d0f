"""Scaffolds: documents proposed from models, and templates of documents."""
