"""Judges of behaviour: success rates of shipped programs by the truth of the simulated world."""
