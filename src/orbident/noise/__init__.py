"""What a recording at rest says of the noise of its sensors."""
