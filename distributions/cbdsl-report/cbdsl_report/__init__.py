"""Pages of learned policies and meta-catalogs."""
