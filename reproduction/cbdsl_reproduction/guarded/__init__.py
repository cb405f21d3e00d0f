"""Scenes, disturbances, peers and counts of ``cb judge guarded``."""
