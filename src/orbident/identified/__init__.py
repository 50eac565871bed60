"""What identified parameters are good for: prediction."""
