"""Functions of bodies in motion, and of frames near a frame."""
