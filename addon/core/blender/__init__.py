"""What is asked of Blender: its devices, OSL, previews and the active material; groups that all materials share.

Also changes that are made whole or not at all. It knows nothing of fits; all other rooms import it.
"""
