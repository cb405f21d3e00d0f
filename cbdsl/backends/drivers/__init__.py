"""Backend of a real robot: state machine, limits and sensors, for any transport."""
