"""What small pictures of clips show."""
