"""A clip or skeleton in another convention, at another scale, with another axis up."""
