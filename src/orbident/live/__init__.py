"""The recursive filter on a stream of samples, in a laboratory."""
