"""``make report``: the paper's claims, and methods side by side, on real data: JSON, Markdown and pictures."""
