"""Work outside Blender's main thread: in worker processes, or in a second Blender; and the pictures that result.

`tasks` holds the work itself and `worker` the process that does it; neither imports bpy. `process` starts workers,
`queue` and `queries` answer panels, `modal` runs operators. This package imports `materials`, `transaction` and
`fitter`.
"""
