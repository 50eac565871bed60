"""What a robot looks like, and where its bodies are over time."""
