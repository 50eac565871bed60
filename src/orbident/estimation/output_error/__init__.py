"""Output error: what momentum conservation predicts, against what sensors showed."""
