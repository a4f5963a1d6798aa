"""Asset libraries: finding measurements in folders, marking materials as assets, and writing .blend files of them.

It imports `jobs`, `materials` and `scene`. Code that opens .blend files (`batch`, `library_file`) runs only in a
Blender of its own.
"""
