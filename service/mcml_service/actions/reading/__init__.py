"""Read clips from files and from the store, and describe them."""
