"""From motion to what sensors would record."""
