"""Server of the Model Context Protocol for programs of cbdsl."""
