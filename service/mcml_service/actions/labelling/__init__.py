"""Motion names of frames, and properties, of one document or many."""
