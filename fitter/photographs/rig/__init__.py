"""What photographs of balls and of flat samples share: the camera, the lamps and how bright they are, a ball that is
found in a picture by its outline, and a `Photograph` itself."""
