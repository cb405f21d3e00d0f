"""Recorded episodes as MCAP files with the schemas of Foxglove."""
