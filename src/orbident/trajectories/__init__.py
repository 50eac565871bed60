"""Joint motions after Eq. 41, as data."""
