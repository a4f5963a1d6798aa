"""Files that are read whole and replaced whole, and arrays in them."""
