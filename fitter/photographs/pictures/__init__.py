"""What pixels are, from a file (`picture_files`) by its exposures (`light`) to the light of a lamp (`reading`)."""
