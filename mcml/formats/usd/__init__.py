"""USD, read with usd-core."""
