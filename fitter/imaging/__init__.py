"""Pictures and plots of fits, in NumPy: what panels, thumbnails and reports show."""
