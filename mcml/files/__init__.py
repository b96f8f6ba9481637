"""Files of any known format: gathered, read, converted, written."""
