"""Projects, the terms on which they are kept, and what was done in them."""
