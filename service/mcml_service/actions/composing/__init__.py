"""New documents of the frames of others, and on the skeletons of others."""
