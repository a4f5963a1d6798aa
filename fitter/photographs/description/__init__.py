"""The description of photographs: what stands in it (`capture_setup`), how it is read from a file or a folder
(`parsing`), and light positions, which are in the place of its lamps (`light_positions`)."""
