"""A motion on another skeleton: which joint is which, how limbs turn, what is said of the outcome."""
