"""Photographs of a flat sample as maps: `reading` reads them, and `photograph`
what points of the sample show. `maps` solves for maps, by `solving` and the `materials` that are found; `judging` and
`advice` say what is wrong and what is missing, `tiling` cuts a part that repeats, and `map_files` writes them."""
