"""What may be wrong with a recording that is refused: each cause is tried."""
