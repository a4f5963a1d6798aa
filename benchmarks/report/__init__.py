"""``make report``: the paper's claims, and methods side by side, on real data: JSON, Markdown and pictures.

`tables`, `comparison` and `times` compute the numbers; `plots` and `figures` draw; `markdown` writes the tables.
"""
