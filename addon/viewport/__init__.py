"""The lobe of a material over the 3D view, with the light dragged; and its plane of incidence beside it."""
