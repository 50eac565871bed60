"""Reading, checking and writing files: one clear line when that fails."""
