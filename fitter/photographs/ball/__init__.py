"""Photographs of a ball as samples: `measuring` reads and gathers them, `photograph` says what a pixel measures,
`placing` where the ball is, and `coverage` what is missing."""
