"""From a recording to samples: screening, clocks, smoothing, fusion of attitudes."""
