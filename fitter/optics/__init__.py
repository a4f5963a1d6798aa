"""Fresnel's equations, and light below a surface."""
