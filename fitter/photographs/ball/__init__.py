"""Photographs of a ball as samples: `measuring` reads and gathers them, `photograph` says what a pixel measures,
`placing` where the ball is, `coverage` what is missing, and `advice` which lamp is next."""
