"""What is asked of Blender: devices, OSL, previews, node trees, the active material; groups that materials share.

Also changes that are made whole or not at all. It knows nothing of fits; all other rooms import it.
"""
