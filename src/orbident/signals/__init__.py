"""From samples to the quantities a regressor needs."""
