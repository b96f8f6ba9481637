"""Documents, and files alone, as files of any format."""
