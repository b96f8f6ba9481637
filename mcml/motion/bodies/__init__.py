"""Questions about motion: what a body does in space, the same on every rig, from positions of its joints."""
