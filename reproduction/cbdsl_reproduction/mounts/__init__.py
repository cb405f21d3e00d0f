"""Mounts of the arms with which manipulability joins the hands: search, map and judgement."""
