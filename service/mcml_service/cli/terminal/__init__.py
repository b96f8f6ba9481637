"""What commands share: options, making them late, how answers look on a terminal."""
