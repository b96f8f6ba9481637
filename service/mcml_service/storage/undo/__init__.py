"""Changes compared and taken back."""
