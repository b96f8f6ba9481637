"""New clips from others: composed, spliced, mirrored, smoothed, resampled."""
