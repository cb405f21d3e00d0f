"""Backend of real robots, and the supervisor that holds them."""
