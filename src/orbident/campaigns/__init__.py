"""Many runs of the same thing: seeds, and the statistics of what comes out."""
