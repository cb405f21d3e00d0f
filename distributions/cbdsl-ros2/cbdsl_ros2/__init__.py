"""ROS 2 by DDS: message types, topics, and a simulated robot that speaks them."""
