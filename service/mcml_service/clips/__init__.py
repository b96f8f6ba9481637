"""Stored documents as clips, and what follows from them: bodies in space, and what is known of them."""
