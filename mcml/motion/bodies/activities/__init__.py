"""Activities of a body in everyday words, such as walk, turn left, jump and sit, found in the positions of joints."""
