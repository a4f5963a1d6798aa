"""What is asked of Blender, of which nothing knows of fits; and changes that are made whole or not at all."""
