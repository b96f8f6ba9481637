"""Quantities of bodies in space, with the same meaning on every rig, from positions of joints."""
