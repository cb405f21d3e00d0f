"""Trials of learning on a Dask cluster."""
