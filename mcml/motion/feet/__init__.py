"""Feet on the ground: contacts, and legs that hold planted feet in place."""
