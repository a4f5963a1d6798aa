"""What a .blend stores of a measured material: properties, paths, edits, and the import results that become them."""
