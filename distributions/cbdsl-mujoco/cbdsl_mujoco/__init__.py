"""Engine of MuJoCo: steady contacts, forces, and a renderer of its own."""
