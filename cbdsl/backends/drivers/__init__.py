"""Backend of a real robot: state machine, limits and sensors, whatever the transport."""
