"""Materials as assets, and the .blend files that they are kept in. Work and slices import it; no other room does."""
