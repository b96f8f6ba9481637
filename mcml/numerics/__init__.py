"""Mathematics on arrays of which two subjects have need; it knows no joints."""
