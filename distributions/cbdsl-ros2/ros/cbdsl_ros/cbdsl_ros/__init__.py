"""Node and launch files of cbdsl."""
