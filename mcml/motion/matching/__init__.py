"""Motion matching: clips as one library of frames that continue each other, and a body that follows a path by it."""
