"""Files, and clips that were made, stored as documents."""
