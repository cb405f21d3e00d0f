"""Recorded episodes as files of ROS 2 messages."""
