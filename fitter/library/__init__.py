"""The starter library: its fits, made beforehand, finishes, and which of its materials a photograph may show."""
