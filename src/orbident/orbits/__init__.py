"""Where a spacecraft is on its orbit, and the Earth, air, sun and field around it."""
