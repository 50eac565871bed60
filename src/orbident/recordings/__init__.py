"""What was measured, when; readers and writers."""
